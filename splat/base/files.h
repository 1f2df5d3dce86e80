// Files written whole or not at all: to a temporary name beside the target, then renamed.
#pragma once

#include <fstream>
#include <functional>
#include <string>
#include <vector>

namespace cosplat {

// Reads a whole file; throws Error when it is missing or unreadable.
std::vector<char> ReadFile(const std::string& path);

// Calls `write` with a stream on `path + ".tmp.<pid>"`, checks the stream (a full disk shows here),
// flushes, and renames. On any failure the temporary file is removed and Error is thrown.
void WriteFileAtomically(const std::string& path, const std::function<void(std::ostream&)>& write);
void WriteFileAtomically(const std::string& path, const std::string& content);

// For writers that insist on opening their own file (OpenCV, tinygltf): hands `write` the temporary
// path (same extension as `path`), then renames.
void WriteViaTemporary(const std::string& path,
                       const std::function<void(const std::string& temporary)>& write);

// The name that WriteViaTemporary uses: in the same folder, with the same extension.
std::string TemporaryPath(const std::string& path);

// Creates a directory and its parents; throws Error with the system's reason.
void MakeDirectories(const std::string& path);

// Lower-case hexadecimal SHA-256 of a file's bytes: names a model without embedding it.
std::string Sha256OfFile(const std::string& path);

}  // namespace cosplat
