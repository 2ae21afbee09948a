// Puts a JSON text and its arrays together (packed_arrays.h).
#include "replay/packed_arrays.h"

namespace cloudcontact::program {

std::string PackedArrays::packed(const Json& json) const {
  std::string text = jsonText(json, -1);
  while ((8 + text.size()) % 8 != 0) text += ' ';
  const auto length = static_cast<std::uint32_t>(text.size());
  std::string bytes = "RPLY";
  for (int k = 0; k < 4; ++k) bytes += static_cast<char>(length >> 8 * k & 255);
  return bytes + text + bytes_;
}

}  // namespace cloudcontact::program
