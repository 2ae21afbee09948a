// Bricks of one material are stored as a code; only bricks of several store a material per voxel.
#include "voxels/materials.h"

namespace cloudcontact {

void Materials::add(const std::string& name, const Cloud::Voxels& own) {
  const auto material = static_cast<std::uint8_t>(body_.materials.size());
  body_.materials.push_back(name);
  body_.materialTable.resize(body_.table.size(), -1);
  BrickCoverage full;
  full.fill(255);
  for (std::size_t entry = 0; entry < body_.table.size(); ++entry) {
    const std::int32_t b = own.table[entry];
    if (b == kEmptyBrick || body_.table[entry] == kEmptyBrick) continue;
    std::int32_t& slot = body_.materialTable[entry];
    if (b == kSolidBrick && slot < 0)
      slot = -1 - material;
    else if (b == kSolidBrick)
      body_.material[slot].fill(material);
    else
      claim(entry, own.coverage[b], material);
  }
}

void Materials::claim(std::size_t entry, const BrickCoverage& own, std::uint8_t material) {
  std::int32_t& slot = body_.materialTable[entry];
  if (slot == -1 - material) return;
  if (slot < 0) {
    BrickMaterial even;
    even.fill(static_cast<std::uint8_t>(-1 - slot));
    slot = static_cast<std::int32_t>(body_.material.size());
    body_.material.push_back(even);
  }
  const std::int32_t b = body_.table[entry];
  BrickMaterial& brick = body_.material[slot];
  for (std::size_t v = 0; v < brick.size(); ++v) {
    const int whole = b == kSolidBrick ? 255 : body_.coverage[b][v];
    if (own[v] > 0 && 2 * own[v] >= whole) brick[v] = material;
  }
}

}  // namespace cloudcontact
