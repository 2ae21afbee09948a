// Bullet's files as bytes: a header, chunks, a last chunk that describes Bullet's structs, and
// after it, where CloudSerializer wrote the file, a checksum, which Bullet does not read.
#pragma once

#include <string>

#include "voxels/cloud_bytes.h"

namespace cloudcontact {

class CloudContact;
class NarrowPhase;

// The contacts of a CloudContact, for files.
struct ContactRecords {
  static const NarrowPhase& narrowPhaseOf(const CloudContact& contact);
};

constexpr char kWorldMagic[8] = {'C', 'L', 'D', 'W', 'O', 'R', 'L', 'D'};
// What follows the last chunk: kWorldMagic and the checksum of all before it.
std::string worldEnd(const char* bytes, std::size_t count);

}  // namespace cloudcontact
