// File reading, and atomic writing: to a temporary file beside the target, which is then renamed.
#pragma once

#include <fstream>
#include <functional>
#include <string>
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

// Lower-case hexadecimal SHA-256 of a file's bytes: identifies a model without embedding it.
std::string Sha256OfFile(const std::string& path);

}  // namespace cosplat
