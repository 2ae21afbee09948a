// Saves worlds, and checks files before Bullet reads them.
#include <BulletDynamics/Dynamics/btDynamicsWorld.h>
#include <cloudcontact/bullet/imported_world.h>
#include <cloudcontact/bullet/shape_report.h>
#include <cloudcontact/bullet/world_file.h>

#include <cstring>

#include "base/byte_archive.h"
#include "base/hash.h"
#include "bullet/contact_record.h"
#include "bullet/shape_record.h"
#include "bullet/world_bytes.h"
#include "field/field_bytes.h"

namespace cloudcontact {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kHeader = 12;
constexpr std::size_t kEnd = sizeof kWorldMagic + sizeof(std::uint64_t);

struct Chunk {
  std::int32_t code = 0, length = 0, structure = 0, count = 0;
};

// Reads numbers as the file orders them.
class WorldBytes {
 public:
  WorldBytes(std::span<const char> bytes, const fs::path& file) : bytes_(bytes), file_(file) {
    if (bytes.size() < kHeader || std::memcmp(bytes.data(), "BULLET", 6) != 0)
      refuseFile(file, "is no file of Bullet");
    wide_ = bytes[7] == '-';
    turned_ = (bytes[8] == 'V') == (std::endian::native == std::endian::little);
  }

  // Walks the chunks to the last one.
  void check() const {
    std::size_t at = kHeader;
    for (;;) {
      const Chunk chunk = chunkAt(at);
      at += headerLength();
      if (chunk.length < 0 || std::size_t(chunk.length) > bytes_.size() - at) cutShort();
      const std::span<const char> data = bytes_.subspan(at, std::size_t(chunk.length));
      if (chunk.structure < 0) checkRecord(data);
      at += data.size();
      if (chunk.code != BT_DNA_CODE) continue;
      if (data.size() < 8 || std::memcmp(data.data(), "SDNANAME", 8) != 0) damaged();
      return checkEnd(at);
    }
  }

 private:
  std::size_t headerLength() const { return wide_ ? 24 : 20; }
  std::int32_t numberAt(std::size_t at) const {
    char number[4];
    for (int i = 0; i < 4; ++i) number[turned_ ? 3 - i : i] = bytes_[at + std::size_t(i)];
    std::int32_t x = 0;
    std::memcpy(&x, number, sizeof x);
    return x;
  }
  Chunk chunkAt(std::size_t at) const {
    if (bytes_.size() - at < headerLength()) cutShort();
    const std::size_t rest = at + headerLength() - 8;  // after Bullet's pointer
    return {numberAt(at), numberAt(at + 4), numberAt(rest), numberAt(rest + 4)};
  }
  // Of ours: it must end within its chunk.
  void checkRecord(std::span<const char> data) const {
    const auto is = [&](const char* kind) {
      return data.size() >= kKindLength && std::memcmp(data.data(), kind, kKindLength) == 0;
    };
    try {
      for (const char* kind : {kShapeKind, kContactsKind})
        if (is(kind)) opened(kind, data.data(), data.size());
    } catch (const std::runtime_error& why) {
      refuseFile(file_, why.what());
    }
    if (data.size() < kFieldLengthAt + 8 || std::memcmp(data.data(), kFieldMagic, 8) != 0) return;
    std::uint64_t length = 0;
    std::memcpy(&length, data.data() + kFieldLengthAt, sizeof length);
    if (inFileOrder(length) > data.size()) damaged();
  }
  void checkEnd(std::size_t at) const {
    if (at == bytes_.size()) return;  // by Bullet's serializer
    if (bytes_.size() - at < kEnd || std::memcmp(&bytes_[at], kWorldMagic, 8) != 0) cutShort();
    if (std::memcmp(&bytes_[at], worldEnd(bytes_.data(), at).data(), kEnd) != 0)
      refuseFile(file_, "is damaged: its checksum does not match; save the world again");
  }
  [[noreturn]] void cutShort() const {
    refuseFile(file_, "is cut short or damaged; save the world again");
  }
  [[noreturn]] void damaged() const { refuseFile(file_, "is damaged; save the world again"); }

  std::span<const char> bytes_;
  const fs::path& file_;
  bool wide_ = true, turned_ = false;
};

}  // namespace

std::string worldEnd(const char* bytes, std::size_t count) {
  WordHash hash;
  hash.add(bytes, count);
  ByteWriter writer;
  writer(hash.value());
  std::string end(kWorldMagic, sizeof kWorldMagic);
  end += writer.bytes();
  return end;
}

void checkWorldBytes(Span<const char> bytes, const fs::path& file) {
  WorldBytes({bytes.data(), bytes.size()}, file).check();
}

CloudSerializer::CloudSerializer(btDynamicsWorld& world, const CloudContact& contact)
    : world_(world), contact_(contact) {}

void CloudSerializer::startSerialization() {
  btDefaultSerializer::startSerialization();
  const std::string record =
      sealed(kContactsKind, contactsOf(world_, ContactRecords::narrowPhaseOf(contact_)));
  writeChunk(*this, contactsKey(), record);
}

void CloudSerializer::save(const fs::path& file) const {
  for (const ShapeReport& cloud : shapeReport(world_))
    if (const std::string why = whyNotKept(*cloud.shape); !why.empty())
      refuseFile(file, "not written: " + why);
  const auto* const bytes = reinterpret_cast<const char*>(getBufferPointer());
  const auto count = static_cast<std::size_t>(getCurrentBufferSize());
  writeWhole(file, [&](std::ostream& out) {
    out.write(bytes, static_cast<std::streamsize>(count));
    const std::string end = worldEnd(bytes, count);
    out.write(end.data(), static_cast<std::streamsize>(end.size()));
  });
}

void saveWorld(btDynamicsWorld& world, const CloudContact& contact, const fs::path& file) {
  CloudSerializer serializer(world, contact);
  world.serialize(&serializer);
  serializer.save(file);
}

}  // namespace cloudcontact
