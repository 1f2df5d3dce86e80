// ZipReader and GunzipReader where there is neither libzip nor zlib: the WebAssembly build. Headers
// are read here, data are inflated by stb_image's zlib decoder, the only part of it that is
// compiled. Sources: PKWARE, .ZIP File Format Specification 6.3.10, sections 4.3.7, 4.3.12
// and 4.3.16; RFC 1952.
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_NO_STDIO
#define STBI_NO_JPEG
#define STBI_NO_PNG
#define STBI_NO_BMP
#define STBI_NO_PSD
#define STBI_NO_TGA
#define STBI_NO_GIF
#define STBI_NO_HDR
#define STBI_NO_PIC
#define STBI_NO_PNM
#define STBI_SUPPORT_ZLIB
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
#include <stb/stb_image.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

#include <algorithm>
#include <array>
#include <cstring>

#include "splat/base/compression.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"
#include "splat/base/zip_archive.h"

namespace {

struct Entry {
  std::string name;
  uint16_t flags = 0, method = 0;
  uint32_t crc = 0;
  uint64_t stored = 0, size = 0, header = 0;  // bytes in the archive, bytes, offset of the header
};

}  // namespace

struct zip {
  std::vector<char> bytes;
  std::vector<Entry> entries;
};

namespace cosplat {

// CRC-32 of ISO 3309, section 4.4.7 of the specification.
uint32_t Crc32(const void* bytes, size_t size, uint32_t before) {
  static const std::array<uint32_t, 256> table = [] {
    std::array<uint32_t, 256> t{};
    for (uint32_t i = 0; i < 256; ++i) {
      t[i] = i;
      for (int bit = 0; bit < 8; ++bit) t[i] = t[i] >> 1 ^ (t[i] & 1 ? 0xedb88320u : 0);
    }
    return t;
  }();
  uint32_t crc = ~before;
  const auto* next = static_cast<const uint8_t*>(bytes);
  for (size_t i = 0; i < size; ++i) crc = crc >> 8 ^ table[(crc ^ next[i]) & 255];
  return ~crc;
}
namespace {

constexpr size_t kEndBytes = 22, kEntryBytes = 46, kHeaderBytes = 30, kEnd64Bytes = 56;
constexpr uint32_t kEndMark = 0x06054b50, kEntryMark = 0x02014b50, kHeaderMark = 0x04034b50;
constexpr uint32_t kEnd64Mark = 0x06064b50, kLocator64Mark = 0x07064b50;
constexpr uint32_t kIn64 = 0xffffffff;         // the number is in the ZIP64 field
constexpr uint64_t kMaxInflated = 0x7fffffff;  // stb's
constexpr uint64_t kMaxRatio = 1032;           // of deflate: more is a lie of the header
constexpr uint16_t kStored = 0, kDeflated = 8, kEncrypted = 1;

// Little-endian, within `bytes`; throws std::string for positions outside.
template <class T>
T At(const std::vector<char>& bytes, uint64_t position) {
  if (position > bytes.size() || bytes.size() - position < sizeof(T))
    throw std::string("the file is truncated");
  T value;
  std::memcpy(&value, &bytes[position], sizeof(T));
  return value;
}

uint64_t FindEnd(const std::vector<char>& bytes) {
  constexpr size_t kMaxComment = 65535;
  if (bytes.size() >= kEndBytes)
    for (uint64_t back = 0; back <= std::min(kMaxComment, bytes.size() - kEndBytes); ++back) {
      const uint64_t at = bytes.size() - kEndBytes - back;
      if (At<uint32_t>(bytes, at) == kEndMark) return at;
    }
  throw std::string("Not a zip archive");
}

// The numbers of the ZIP64 extra field stand for those that are kIn64, in this order.
void Read64(const std::vector<char>& bytes, uint64_t extra, uint16_t extra_bytes, Entry& entry) {
  for (uint64_t at = extra; at + 4 <= extra + extra_bytes;) {
    const uint16_t id = At<uint16_t>(bytes, at), length = At<uint16_t>(bytes, at + 2);
    uint64_t next = at + 4;
    if (id == 1)
      for (uint64_t* number : {&entry.size, &entry.stored, &entry.header})
        if (*number == kIn64) {
          *number = At<uint64_t>(bytes, next);
          next += 8;
        }
    at += 4 + length;
  }
}

std::vector<Entry> ReadDirectory(const std::vector<char>& bytes) {
  const uint64_t end = FindEnd(bytes);
  uint64_t count = At<uint16_t>(bytes, end + 10), at = At<uint32_t>(bytes, end + 16);
  if (end >= 20 && At<uint32_t>(bytes, end - 20) == kLocator64Mark) {
    const uint64_t end64 = At<uint64_t>(bytes, end - 12);
    if (At<uint32_t>(bytes, end64) != kEnd64Mark || bytes.size() - end64 < kEnd64Bytes)
      throw std::string("the directory is damaged");
    count = At<uint64_t>(bytes, end64 + 32);
    at = At<uint64_t>(bytes, end64 + 48);
  }
  if (count > bytes.size() / kEntryBytes) throw std::string("the directory is damaged");
  std::vector<Entry> entries(count);
  for (Entry& entry : entries) {
    if (At<uint32_t>(bytes, at) != kEntryMark) throw std::string("the directory is damaged");
    entry.flags = At<uint16_t>(bytes, at + 8);
    entry.method = At<uint16_t>(bytes, at + 10);
    entry.crc = At<uint32_t>(bytes, at + 16);
    entry.stored = At<uint32_t>(bytes, at + 20);
    entry.size = At<uint32_t>(bytes, at + 24);
    entry.header = At<uint32_t>(bytes, at + 42);
    const uint16_t name = At<uint16_t>(bytes, at + 28), extra = At<uint16_t>(bytes, at + 30),
                   comment = At<uint16_t>(bytes, at + 32);
    if (bytes.size() - at < kEntryBytes + name) throw std::string("the file is truncated");
    entry.name.assign(&bytes[at] + kEntryBytes, name);
    Read64(bytes, at + kEntryBytes + name, extra, entry);
    at += kEntryBytes + name + extra + comment;
  }
  return entries;
}

// The bytes of a member. Throws std::string.
std::vector<char> Unpack(const zip& archive, const Entry& entry) {
  constexpr uint64_t kLookAhead = 4;
  const std::vector<char>& bytes = archive.bytes;
  if (entry.flags & kEncrypted) throw std::string("is encrypted");
  if (At<uint32_t>(bytes, entry.header) != kHeaderMark) throw std::string("has no header");
  const uint64_t data = entry.header + kHeaderBytes + At<uint16_t>(bytes, entry.header + 26) +
                        At<uint16_t>(bytes, entry.header + 28);
  if (entry.stored > kMaxInflated - kLookAhead || entry.size > kMaxInflated ||
      entry.size / kMaxRatio > entry.stored)
    throw "has " + std::to_string(entry.size) + " bytes";
  if (data > bytes.size() || bytes.size() - data < entry.stored + kLookAhead)
    throw std::string("the file is truncated");
  std::vector<char> out(entry.size);
  if (entry.method == kStored && entry.stored == entry.size) {
    std::copy_n(bytes.begin() + long(data), entry.size, out.begin());
  } else if (entry.method == kDeflated) {
    // The decoder looks up to four bytes ahead; here they are the directory's.
    const int size = stbi_zlib_decode_noheader_buffer(
        out.data(), int(out.size()), bytes.data() + data, int(entry.stored + kLookAhead));
    if (size != int(out.size())) throw std::string("the compressed data are damaged");
  } else {
    throw "has compression method " + std::to_string(entry.method);
  }
  if (Crc32(out.data(), out.size()) != entry.crc) throw std::string("its checksum is wrong");
  return out;
}

// The position after gzip's header, RFC 1952 section 2.3. Throws std::string.
uint64_t AfterGzipHeader(const std::vector<char>& bytes) {
  constexpr uint8_t kDeflate = 8, kCrc = 2, kExtra = 4, kName = 8, kComment = 16;
  if (At<uint8_t>(bytes, 0) != 0x1f || At<uint8_t>(bytes, 1) != 0x8b ||
      At<uint8_t>(bytes, 2) != kDeflate)
    throw std::string("not gzip");
  const uint8_t flags = At<uint8_t>(bytes, 3);
  uint64_t at = 10;
  if (flags & kExtra) at += 2 + At<uint16_t>(bytes, at);
  for (const uint8_t text : {kName, kComment})
    if (flags & text)
      while (At<char>(bytes, at++) != 0) continue;
  return flags & kCrc ? at + 2 : at;
}

std::vector<char> Gunzip(const std::vector<char>& bytes) {
  constexpr uint64_t kTrailer = 8;
  const uint64_t at = AfterGzipHeader(bytes);
  if (bytes.size() < at + kTrailer) throw std::string("the file is truncated");
  const uint64_t stored = bytes.size() - at - kTrailer;
  const uint32_t size = At<uint32_t>(bytes, bytes.size() - 4);
  if (bytes.size() > kMaxInflated || size > kMaxInflated || size / kMaxRatio > stored)
    throw "states " + std::to_string(size) + " bytes";
  std::vector<char> out(size);
  const int written = stbi_zlib_decode_noheader_buffer(
      out.data(), int(size), bytes.data() + at, int(stored + kTrailer));
  if (written != int(size)) throw std::string("the compressed data are damaged");
  if (Crc32(out.data(), out.size()) != At<uint32_t>(bytes, bytes.size() - kTrailer))
    throw std::string("its checksum is wrong");
  return out;
}

}  // namespace

// Inflated at once: of the size that the trailer states, if deflate can make that much.
struct GunzipReader::Stream {
  std::vector<char> bytes;
  size_t next = 0;
};

GunzipReader::GunzipReader(const std::string& path, const std::vector<char>& bytes)
    : path_(path), stream_(std::make_unique<Stream>()) {
  try {
    stream_->bytes = Gunzip(bytes);
  } catch (const std::string& problem) {
    throw Error(path, "is damaged: " + problem);
  }
}

GunzipReader::~GunzipReader() = default;

std::vector<unsigned char> GunzipReader::Read(const std::string& field, size_t size) {
  Stream& stream = *stream_;
  if (size > stream.bytes.size() - stream.next)
    throw Error(path_,
                field,
                "the file ends after " + std::to_string(stream.bytes.size() - stream.next) +
                    " of " + std::to_string(size) + " bytes");
  const auto begin = stream.bytes.begin() + long(stream.next);
  stream.next += size;
  return std::vector<unsigned char>(begin, begin + long(size));
}

std::vector<char> GunzipReader::ReadUpTo(size_t size) {
  Stream& stream = *stream_;
  const auto begin = stream.bytes.begin() + long(stream.next);
  const size_t count = std::min(size, stream.bytes.size() - stream.next);
  stream.next += count;
  return std::vector<char>(begin, begin + long(count));
}

void ZipReader::Discard::operator()(zip* archive) const { delete archive; }

ZipReader::ZipReader(const std::string& path, const std::string& kind)
    : ZipReader(path, kind, ReadFile(path)) {}

ZipReader::ZipReader(const std::string& path, const std::string& kind, std::vector<char> bytes)
    : path_(path) {
  archive_.reset(new zip{std::move(bytes), {}});
  try {
    archive_->entries = ReadDirectory(archive_->bytes);
  } catch (const std::string& problem) {
    throw Error(path, "cannot be read as " + kind + ": " + problem);
  }
  CheckTotal();
}

void ZipReader::CheckTotal() const {
  uint64_t total = 0;
  for (const Entry& entry : archive_->entries) {
    if (entry.size > kMaxArchiveBytes - total) throw TooMuchUnpacked(path_, entry.name);
    total += entry.size;
  }
}

size_t ZipReader::size() const { return archive_->entries.size(); }

std::string ZipReader::Name(size_t index) const { return archive_->entries[index].name; }

size_t ZipReader::Find(const std::string& name) const {
  const auto& entries = archive_->entries;
  return size_t(std::find_if(entries.begin(),
                             entries.end(),
                             [&](const Entry& entry) { return entry.name == name; }) -
                entries.begin());
}

std::vector<char> ZipReader::Read(size_t index, uint64_t limit) const {
  const Entry& entry = archive_->entries.at(index);
  if (entry.size > limit)
    throw Error(
        path_, entry.name, Format("has {} bytes, at most {} are accepted", entry.size, limit));
  try {
    return Unpack(*archive_, entry);
  } catch (const std::string& problem) {
    throw Error(path_, entry.name, "is damaged: " + problem);
  }
}

}  // namespace cosplat
