// A library for LD_PRELOAD that makes a disk fail, for the tests of what a program then does.
//
//   COSPLAT_FAULT=KIND:TEXT   the fault, and which files have it: those with TEXT in their path
//   COSPLAT_FAULT_LOG=FILE    instead, one line "read PATH" or "write PATH" per file opened
//
//   full          writing fails with ENOSPC, after the first kWritten bytes of each file
//   readonly      opening for writing, making folders, renaming and removing fail with EROFS
//   write-error   writing fails with EIO
//   sync-error    fsync fails with EIO
//   short-write   a call of write writes at most kPiece bytes
//   read-error    reading fails with EIO
//   short-read    a call of read reads at most kPiece bytes
//   vanish        opening for reading and renaming fail with ENOENT, as if the file was removed
//
// It interposes the calls that the C++ library, OpenCV, FFmpeg and libzip make. Files that are
// written by stdio (libzip) fail in fwrite and fflush.
#include <dlfcn.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>

namespace {

constexpr size_t kPiece = 113, kWritten = 100;
constexpr int kMaxFiles = 4096;

enum class Fault {
  kNone,
  kFull,
  kReadOnly,
  kWriteError,
  kSyncError,
  kShortWrite,
  kReadError,
  kShortRead,
  kVanish
};

struct Settings {
  Fault fault = Fault::kNone;
  std::string text, log;
};

Settings Read() {
  Settings settings;
  if (const char* log = std::getenv("COSPLAT_FAULT_LOG")) settings.log = log;
  const char* const given = std::getenv("COSPLAT_FAULT");
  if (!given) return settings;
  const std::string all = given;
  const size_t colon = all.find(':');
  settings.text = colon == std::string::npos ? "" : all.substr(colon + 1);
  const std::string kind = all.substr(0, colon);
  const char* const kinds[] = {"none",
                               "full",
                               "readonly",
                               "write-error",
                               "sync-error",
                               "short-write",
                               "read-error",
                               "short-read",
                               "vanish"};
  for (int k = 0; k <= int(Fault::kVanish); ++k)
    if (kind == kinds[k]) settings.fault = Fault(k);
  if (settings.fault == Fault::kNone) {
    fprintf(stderr, "COSPLAT_FAULT: unknown kind '%s'\n", kind.c_str());
    _exit(99);
  }
  return settings;
}

const Settings& Get() {
  static const Settings settings = Read();
  return settings;
}

template <class F>
F Next(F, const char* name) {
  return reinterpret_cast<F>(dlsym(RTLD_NEXT, name));
}
#define NEXT(function) (*Next(&function, #function))

// Open files that have the fault, and how much was written to each.
std::atomic<bool> faulty[kMaxFiles];
std::atomic<size_t> written[kMaxFiles];

bool Matches(const char* path) {
  return Get().fault != Fault::kNone && path && strstr(path, Get().text.c_str());
}

bool Has(int file, Fault fault) {
  return Get().fault == fault && file >= 0 && file < kMaxFiles && faulty[file];
}

void Log(const char* what, const char* path) {
  if (Get().log.empty()) return;
  const int file = NEXT(open)(Get().log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  const std::string line = std::string(what) + " " + path + "\n";
  if (NEXT(write)(file, line.data(), line.size()) < 0) abort();
  NEXT(close)(file);
}

// Whether opening fails, with errno set.
bool OpeningFails(const char* path, bool writes) {
  Log(writes ? "write" : "read", path);
  if (!Matches(path)) return false;
  if (writes && Get().fault == Fault::kReadOnly)
    errno = EROFS;
  else if (!writes && Get().fault == Fault::kVanish)
    errno = ENOENT;
  else
    return false;
  return true;
}

int Opened(int file, const char* path) {
  if (file >= 0 && file < kMaxFiles) {
    faulty[file] = Matches(path);
    written[file] = 0;
  }
  return file;
}

bool Writes(int flags) { return (flags & O_ACCMODE) != O_RDONLY || (flags & O_CREAT) != 0; }
bool Writes(const char* mode) { return strpbrk(mode, "wa+") != nullptr; }

// Fails (-1), or how many bytes may be written.
ssize_t MayWrite(int file, size_t size) {
  if (Has(file, Fault::kWriteError)) return errno = EIO, -1;
  if (Has(file, Fault::kShortWrite)) return ssize_t(std::min(size, kPiece));
  if (!Has(file, Fault::kFull)) return ssize_t(size);
  const size_t before = written[file];
  const size_t fits = std::min(size, kWritten - std::min(kWritten, before));
  if (fits == 0 && size > 0) return errno = ENOSPC, -1;
  written[file] = before + fits;
  return ssize_t(fits);
}

ssize_t MayRead(int file, size_t size) {
  if (Has(file, Fault::kReadError)) return errno = EIO, -1;
  return ssize_t(Has(file, Fault::kShortRead) ? std::min(size, kPiece) : size);
}

bool NameFails(const char* path) {
  if (!Matches(path) || Get().fault != Fault::kReadOnly) return false;
  errno = EROFS;
  return true;
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) ? va_arg(arguments, mode_t) : 0;
  va_end(arguments);
  if (OpeningFails(path, Writes(flags))) return -1;
  return Opened(NEXT(open)(path, flags, mode), path);
}

int open64(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) ? va_arg(arguments, mode_t) : 0;
  va_end(arguments);
  return open(path, flags, mode);
}

FILE* fopen64(const char* path, const char* mode) {
  if (OpeningFails(path, Writes(mode))) return nullptr;
  FILE* const file = NEXT(fopen64)(path, mode);
  if (file) Opened(fileno(file), path);
  return file;
}

FILE* fopen(const char* path, const char* mode) { return fopen64(path, mode); }

ssize_t write(int file, const void* bytes, size_t size) {
  const ssize_t fits = MayWrite(file, size);
  return fits < 0 ? -1 : NEXT(write)(file, bytes, size_t(fits));
}

ssize_t writev(int file, const iovec* parts, int count) {
  const bool faulted =
      Has(file, Fault::kFull) || Has(file, Fault::kWriteError) || Has(file, Fault::kShortWrite);
  if (!faulted) return NEXT(writev)(file, parts, count);
  ssize_t done = 0;
  for (int i = 0; i < count; ++i) {
    const ssize_t now = write(file, parts[i].iov_base, parts[i].iov_len);
    if (now < 0) return done > 0 ? done : -1;
    done += now;
    if (size_t(now) < parts[i].iov_len) break;
  }
  return done;
}

size_t fwrite(const void* bytes, size_t size, size_t count, FILE* stream) {
  const int file = fileno(stream);
  const bool faulted = Has(file, Fault::kWriteError) || Has(file, Fault::kFull);
  if (!faulted || MayWrite(file, size * count) == ssize_t(size * count))
    return NEXT(fwrite)(bytes, size, count, stream);
  stream->_flags |= _IO_ERR_SEEN;                  // for ferror
  errno = Has(file, Fault::kFull) ? ENOSPC : EIO;  // also where a part of it would fit
  return 0;
}

ssize_t read(int file, void* bytes, size_t size) {
  const ssize_t fits = MayRead(file, size);
  return fits < 0 ? -1 : NEXT(read)(file, bytes, size_t(fits));
}

size_t fread(void* bytes, size_t size, size_t count, FILE* stream) {
  if (Has(fileno(stream), Fault::kReadError)) {
    stream->_flags |= _IO_ERR_SEEN;
    return errno = EIO, 0;
  }
  return NEXT(fread)(bytes, size, count, stream);
}

int fsync(int file) {
  if (Has(file, Fault::kSyncError)) return errno = EIO, -1;
  return NEXT(fsync)(file);
}

int rename(const char* from, const char* to) {
  if (NameFails(from) || NameFails(to)) return -1;
  if ((Matches(from) || Matches(to)) && Get().fault == Fault::kVanish) return errno = ENOENT, -1;
  return NEXT(rename)(from, to);
}

int mkdir(const char* path, mode_t mode) { return NameFails(path) ? -1 : NEXT(mkdir)(path, mode); }

int unlink(const char* path) { return NameFails(path) ? -1 : NEXT(unlink)(path); }

int remove(const char* path) { return NameFails(path) ? -1 : NEXT(remove)(path); }

int close(int file) {
  if (file >= 0 && file < kMaxFiles) faulty[file] = false;
  return NEXT(close)(file);
}

}  // extern "C"
