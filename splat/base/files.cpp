#include "splat/base/files.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "splat/base/error.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

std::string SystemReason(const std::string& fallback) {
  return errno != 0 ? std::strerror(errno) : fallback;
}

// Removes a temporary file unless it was renamed into place.
class TemporaryFile {
 public:
  explicit TemporaryFile(std::string path) : path_(std::move(path)) {}
  ~TemporaryFile() {
    if (kept_) return;
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::string& path() const { return path_; }

  void RenameTo(const std::string& target) {
    std::error_code code;
    fs::rename(path_, target, code);
    if (code) throw Error(target, "cannot be written: " + code.message());
    kept_ = true;
  }

 private:
  std::string path_;
  bool kept_ = false;
};

// A device or pipe (/dev/stdout) cannot be replaced by a rename, so it is written directly.
bool IsSpecialFile(const std::string& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

// In their order.
void ForBlocks(const std::string& path, const std::function<void(const char*, size_t)>& use) {
  std::error_code code;
  if (fs::is_directory(path, code)) throw Error(path, "is a folder, expected a file");
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw Error(path, "cannot be read: " + SystemReason("open failed"));
  std::vector<char> block(1 << 16);
  while (stream.read(block.data(), block.size()) || stream.gcount() > 0)
    use(block.data(), size_t(stream.gcount()));
  if (stream.bad()) throw Error(path, "read failed: " + SystemReason("stream error"));
}

void WriteStream(const std::string& file,
                 const std::string& name_in_errors,
                 const std::function<void(std::ostream&)>& write) {
  errno = 0;
  std::ofstream stream(file, std::ios::binary | std::ios::trunc);
  if (!stream) throw Error(name_in_errors, "cannot be written: " + SystemReason("open failed"));
  write(stream);
  stream.flush();
  if (stream) stream.close();
  if (!stream) throw Error(name_in_errors, "write failed: " + SystemReason("stream error"));
}

// Waits until a file's content, or a folder's list of files, is on the disk.
void Sync(const std::string& path, const std::string& name_in_errors) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = file >= 0 && fsync(file) == 0;
  const int problem = errno;
  if (file >= 0) close(file);
  // EINVAL: a file system without it.
  if (!synced && problem != EINVAL)
    throw Error(name_in_errors, std::string("write failed: ") + std::strerror(problem));
}

constexpr const char* kTemporary = ".tmp.";

std::string TemporarySuffix() { return kTemporary + std::to_string(getpid()); }

// Whether the name is that of a temporary file, "NAME.tmp.PID" or "NAME.tmp.PID.EXTENSION", of a
// process that is gone.
bool IsAbandoned(const std::string& name) {
  const size_t found = name.rfind(kTemporary);
  if (found == std::string::npos) return false;
  const char* const digits = name.c_str() + found + std::strlen(kTemporary);
  char* end = nullptr;
  const long pid = std::strtol(digits, &end, 10);
  if (end == digits || (*end != '\0' && *end != '.') || pid <= 0) return false;
  return kill(pid_t(pid), 0) != 0 && errno == ESRCH;
}

}  // namespace

std::vector<char> ReadFile(const std::string& path) {
  std::error_code code;
  std::vector<char> bytes;
  const auto size = fs::file_size(path, code);
  if (!code) bytes.reserve(size);
  ForBlocks(path, [&](const char* block, size_t count) {
    bytes.insert(bytes.end(), block, block + count);
  });
  return bytes;
}

void WriteFileAtomically(const std::string& path, const std::function<void(std::ostream&)>& write) {
  if (IsSpecialFile(path)) return WriteStream(path, path, write);
  TemporaryFile temporary(path + TemporarySuffix());
  WriteStream(temporary.path(), path, write);
  temporary.RenameTo(path);
}

void WriteFileAtomically(const std::string& path, const std::string& content) {
  WriteFileAtomically(path, [&](std::ostream& out) { out.write(content.data(), content.size()); });
}

void WriteFileDurably(const std::string& path, const std::function<void(std::ostream&)>& write) {
  if (IsSpecialFile(path)) return WriteStream(path, path, write);
  TemporaryFile temporary(path + TemporarySuffix());
  WriteStream(temporary.path(), path, write);
  Sync(temporary.path(), path);
  temporary.RenameTo(path);
  const std::string folder = fs::path(path).parent_path().string();
  Sync(folder.empty() ? "." : folder, path);
}

std::string TemporaryPath(const std::string& path) {
  const fs::path target(path);
  const fs::path name = target.stem().string() + TemporarySuffix() + target.extension().string();
  return (target.parent_path() / name).string();
}

void WriteViaTemporary(const std::string& path,
                       const std::function<void(const std::string& temporary)>& write) {
  if (IsSpecialFile(path)) return write(path);
  TemporaryFile temporary(TemporaryPath(path));
  write(temporary.path());
  temporary.RenameTo(path);
}

void RemoveFile(const std::string& path) {
  std::error_code code;
  fs::remove(path, code);
  if (code) throw Error(path, "cannot be removed: " + code.message());
}

void RemoveTemporaries(const std::string& folder) {
  std::error_code code;
  std::vector<fs::path> abandoned;
  for (fs::recursive_directory_iterator entry(folder, code), end; !code && entry != end;
       entry.increment(code)) {
    const std::string name = entry->path().filename().string();
    if (entry->is_regular_file(code) && IsAbandoned(name)) abandoned.push_back(entry->path());
  }
  for (const fs::path& path : abandoned) fs::remove(path, code);
}

void MakeDirectories(const std::string& path) {
  std::error_code code;
  fs::create_directories(path, code);
  if (!code && !fs::is_directory(path)) code = std::make_error_code(std::errc::not_a_directory);
  if (code) throw Error(path, "cannot create folder: " + code.message());
}

uint32_t Crc32OfFile(const std::string& path, uint32_t before) {
  ForBlocks(path, [&](const char* block, size_t count) { before = Crc32(block, count, before); });
  return before;
}

std::string Sha256OfFile(const std::string& path) {
  const std::vector<char> bytes = ReadFile(path);
  return Sha256(bytes.data(), bytes.size());
}

}  // namespace cosplat
