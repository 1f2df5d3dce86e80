#include "splat/base/compression.h"

#include <zlib.h>

#include <algorithm>
#include <limits>

#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

constexpr int kGzipHeader = 16 + MAX_WBITS;  // zlib: gzip's header and checksum around the stream

// zlib counts in 32 bits.
uInt Chunk(size_t left) { return uInt(std::min<size_t>(left, 1u << 30)); }

}  // namespace

uint32_t Crc32(const void* bytes, size_t size, uint32_t before) {
  if (size == 0) return before;  // zlib starts again at a null pointer
  return uint32_t(crc32_z(before, static_cast<const Bytef*>(bytes), size));
}

struct GunzipReader::Stream {
  z_stream z{};
  const unsigned char* next = nullptr;  // not given to zlib yet
  size_t left = 0;
};

GunzipReader::GunzipReader(const std::string& path, const std::vector<char>& bytes)
    : path_(path), stream_(std::make_unique<Stream>()) {
  stream_->next = reinterpret_cast<const unsigned char*>(bytes.data());
  stream_->left = bytes.size();
  if (inflateInit2(&stream_->z, kGzipHeader) != Z_OK) throw Error(path, "zlib cannot be started");
}

GunzipReader::~GunzipReader() { inflateEnd(&stream_->z); }

size_t GunzipReader::Inflate(const std::string& field, unsigned char* out, size_t size, bool& cut) {
  z_stream& z = stream_->z;
  size_t done = 0;
  while (done < size) {
    if (z.avail_in == 0) {
      z.next_in = const_cast<unsigned char*>(stream_->next);
      z.avail_in = Chunk(stream_->left);
      stream_->next += z.avail_in;
      stream_->left -= z.avail_in;
    }
    z.next_out = out + done;
    const uInt room = Chunk(size - done);
    z.avail_out = room;
    const int status = inflate(&z, Z_NO_FLUSH);
    done += room - z.avail_out;
    if (done == size) break;
    cut = status == Z_BUF_ERROR && stream_->left == 0;
    // gzip files may follow each other in one; what else follows is not of the file.
    if (status == Z_STREAM_END && z.avail_in >= 2 && z.next_in[0] == 0x1f && z.next_in[1] == 0x8b) {
      inflateReset(&z);
      continue;
    }
    if (cut || status == Z_STREAM_END) break;
    if (status != Z_OK && status != Z_BUF_ERROR)
      throw Error(path_, field, std::string("is damaged: ") + (z.msg ? z.msg : "not gzip"));
  }
  return done;
}

std::vector<unsigned char> GunzipReader::Read(const std::string& field, size_t size) {
  std::vector<unsigned char> out(size);
  bool cut = false;
  const size_t done = Inflate(field, out.data(), size, cut);
  if (done < size)
    throw Error(path_, field, Format("the file ends after {} of {} bytes", done, size));
  return out;
}

std::vector<char> GunzipReader::ReadUpTo(size_t size) {
  std::vector<char> out(size);
  bool cut = false;
  out.resize(Inflate("gzip", reinterpret_cast<unsigned char*>(out.data()), size, cut));
  if (cut) throw Error(path_, "gzip", Format("is truncated after {} bytes", out.size()));
  return out;
}

std::string Gzip(const std::string& bytes) {
  if (bytes.size() > std::numeric_limits<uInt>::max())
    throw Error("gzip", std::to_string(bytes.size()) + " bytes are more than zlib takes at once");
  z_stream z{};
  if (deflateInit2(&z, Z_BEST_COMPRESSION, Z_DEFLATED, kGzipHeader, 9, Z_DEFAULT_STRATEGY) != Z_OK)
    throw Error("gzip", "zlib cannot be started");
  std::string out(deflateBound(&z, uLong(bytes.size())), '\0');
  z.next_in = reinterpret_cast<unsigned char*>(const_cast<char*>(bytes.data()));
  z.avail_in = uInt(bytes.size());
  z.next_out = reinterpret_cast<unsigned char*>(out.data());
  z.avail_out = uInt(out.size());
  const int status = deflate(&z, Z_FINISH);
  out.resize(z.total_out);
  deflateEnd(&z);
  if (status != Z_STREAM_END) throw Error("gzip", "failed with code " + std::to_string(status));
  return out;
}

}  // namespace cosplat
