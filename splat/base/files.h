// File reading, and atomic writing: to a temporary file beside the target, which is then renamed.
// Checksums, and what a file is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace cosplat {

// Reads a whole file; throws Error when it is missing or unreadable.
std::vector<char> ReadFile(const std::string& path);

// Calls `write` with a stream to `path + ".tmp.<pid>"`, flushes and checks the stream (which
// detects a full disk), and renames the file. On any failure the temporary file is removed and
// Error is thrown.
void WriteFileAtomically(const std::string& path, const std::function<void(std::ostream&)>& write);
void WriteFileAtomically(const std::string& path, const std::string& content);
// The same, on the disk when it returns (fsync), so that a power failure leaves the earlier file or
// this one.
void WriteFileDurably(const std::string& path, const std::function<void(std::ostream&)>& write);

// For writers that open their own file (OpenCV, tinygltf): passes `write` the temporary path (same
// extension as `path`), then renames the file.
void WriteViaTemporary(const std::string& path,
                       const std::function<void(const std::string& temporary)>& write);

// The path that WriteViaTemporary uses: in the same folder, with the same extension.
std::string TemporaryPath(const std::string& path);

// Removes a file, if it is there; throws Error with the system's reason.
void RemoveFile(const std::string& path);

// Removes the temporary files, in a folder and those in it, of writers that were killed. Those of
// running processes stay.
void RemoveTemporaries(const std::string& folder);

// Creates a directory and its parents; throws Error with the system's reason.
void MakeDirectories(const std::string& path);

// SHA-256 (FIPS 180-4) as 64 lower-case hexadecimal digits: identifies a model without embedding
// it.
std::string Sha256(const void* bytes, size_t size);
std::string Sha256OfFile(const std::string& path);

// CRC-32 (ISO 3309, as in zip and PNG) of `size` bytes that follow those with checksum `before`:
// finds damage and changes that are not malicious.
uint32_t Crc32(const void* bytes, size_t size, uint32_t before = 0);
// Throws Error as ReadFile does.
uint32_t Crc32OfFile(const std::string& path, uint32_t before = 0);

// From the first bytes of a file (64 are enough), for the errors of all readers: what it is that is
// not what a reader expects, and what to do about it, as the end of a sentence ("is a web page ...,
// download it again"). Empty: nothing that people have by mistake.
std::string OtherContent(std::string_view begin);

// What that is of a camera's raw image.
inline constexpr char kRawImage[] =
    "is a camera's raw image, which is not read: develop it to JPEG or TIFF";

}  // namespace cosplat
