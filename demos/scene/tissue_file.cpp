// Reads tables of tissues. A missing or unknown field is an error.
#include "scene/tissue_file.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "io/errors.h"
#include "io/json.h"
#include "io/text.h"

namespace cloudcontact::program {

namespace {

std::string namesOf(const TissueTable& table) {
  std::string names;
  for (const Tissue& t : table) names += (names.empty() ? "" : ", ") + printable(t.name);
  return names;
}

Tissue tissueOf(const Json& json, const std::string& where) {
  if (!json.is_object() || !json.contains("name") || !json["name"].is_string())
    throw BadInput(where + ": each tissue is an object with a name");
  Tissue tissue;
  tissue.name = json["name"].get<std::string>();
  const std::pair<const char*, double*> fields[] = {{"stiffness", &tissue.stiffness},
                                                    {"damping", &tissue.damping},
                                                    {"hardness", &tissue.hardness},
                                                    {"density", &tissue.density}};
  for (const auto& [name, value] : fields) {
    if (!json.contains(name) || !json[name].is_number())
      throw BadInput(where + ": tissue " + printable(tissue.name) + " needs a number " + name +
                     " (stiffness N/m, damping N s/m, hardness Pa, density kg/m^3)");
    *value = json[name].get<double>();
  }
  const bool isElastic = json.contains("elasticity");
  if (isElastic && !json["elasticity"].is_number())
    throw BadInput(where + ": tissue " + printable(tissue.name) +
                   ": elasticity is no number; give a modulus in Pa");
  if (isElastic) tissue.elasticity = json["elasticity"].get<double>();
  if (json.size() != (isElastic ? 6 : 5))
    throw BadInput(where + ": tissue " + printable(tissue.name) +
                   " has a field that is not known; use name, stiffness, damping, hardness, "
                   "density, and elasticity for what deforms");
  return tissue;
}

}  // namespace

TissueTable readTissues(const std::string& option, const std::string& text, double stiffness) {
  if (text == "dental") return dentalTissues(stiffness);
  const std::string where = option + ": " + text;
  std::ifstream file(text, std::ios::binary);
  if (!file || !text.ends_with(".json"))
    throw BadInput(where +
                   " is neither dental nor a file that can be read; give one ending in .json");
  const std::string content{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const Json json = Json::parse(content, nullptr, false);
  if (!json.is_array() || json.empty())
    throw BadInput(where + ": is no JSON list of tissues; write [{\"name\": ...}, ...]");
  TissueTable table;
  for (const Json& entry : json) table.push_back(tissueOf(entry, where));
  try {
    validate(table);
  } catch (const std::invalid_argument& error) {
    throw BadInput(where + ": " + error.what());
  }
  return table;
}

TissueTable tableOf(const TissueOptions& options, const std::string& usual) {
  if (!options.made.empty()) {
    validate(options.made);
    return options.made;
  }
  return readTissues("--tissues", options.table.empty() ? usual : options.table);
}

TissueTable tissuesOfParts(const std::string& body, const TissueTable& table,
                           const std::vector<std::string>& parts,
                           const std::vector<std::pair<std::string, std::string>>& tissueOfPart) {
  std::vector<std::string> all = parts;
  if (all.empty()) all = {"all"};
  for (const auto& [part, tissue] : tissueOfPart)
    if (std::find(all.begin(), all.end(), part) == all.end()) {
      std::string names;
      for (const std::string& name : all) names += (names.empty() ? "" : ", ") + printable(name);
      throw BadInput("--tissue: " + body + " has no part " + part + "; its parts are " + names);
    }
  TissueTable found;
  for (const std::string& part : all) {
    std::string name = parts.empty() ? table.front().name : part;
    for (const auto& [of, tissue] : tissueOfPart)
      if (of == part) name = tissue;
    const auto at =
        std::find_if(table.begin(), table.end(), [&](const Tissue& t) { return t.name == name; });
    if (at == table.end() && name != part)
      throw BadInput("--tissue: " + printable(name) + " is no tissue of the table; give one of " +
                     namesOf(table));
    if (at == table.end())
      throw BadInput(body + ": its part " + printable(part) +
                     " is no tissue of the table; give --tissue \"" + printable(part) +
                     "=NAME\" with one of " + namesOf(table));
    found.push_back(*at);
  }
  return found;
}

BodyTissues::BodyTissues(const TissueOptions& options) : ofParts_(options.ofParts) {
  if (options.hasTable()) table_ = tableOf(options, "");
}

TissueTable BodyTissues::of(const std::string& body, const std::vector<std::string>& parts) {
  const std::vector<std::string> all = parts.empty() ? std::vector<std::string>{"all"} : parts;
  seen_.insert(all.begin(), all.end());
  std::vector<std::pair<std::string, std::string>> own;
  for (const auto& entry : ofParts_)
    if (std::find(all.begin(), all.end(), entry.first) != all.end()) own.push_back(entry);
  const bool isNamed = std::any_of(table_.begin(), table_.end(), [&](const Tissue& t) {
    return std::find(parts.begin(), parts.end(), t.name) != parts.end();
  });
  if (table_.empty() || (own.empty() && !isNamed)) return {};
  any_ = true;
  return tissuesOfParts(body, table_, parts, own);
}

void BodyTissues::check() const {
  if (table_.empty()) return;
  std::string names;
  for (const std::string& name : seen_) names += (names.empty() ? "" : ", ") + printable(name);
  for (const auto& [part, tissue] : ofParts_)
    if (!seen_.contains(part))
      throw BadInput("--tissue: no body has a part " + printable(part) + "; the parts are " +
                     names);
  if (!any_)
    throw BadInput("--tissues: no part has a tissue; give --tissue PART=TISSUE with one of " +
                   names + " for PART and one of " + namesOf(table_) + " for TISSUE");
}

}  // namespace cloudcontact::program
