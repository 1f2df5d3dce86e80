// A state in memory instead of a file (splat/base/state_file.h): the fields' bytes, one after
// another.
#pragma once

#include <cstring>
#include <string>
#include <vector>

#include "splat/base/error.h"
#include "splat/base/state_file.h"

namespace cosplat::test {

class MemoryArchive : public StateArchive {
 public:
  // From now on it reads what was written, from the beginning.
  void Rewind() {
    reads_ = true;
    position_ = 0;
  }
  bool reads() const override { return reads_; }
  void Fail(const std::string& name, const std::string& problem) const override {
    throw Error(name, problem);
  }

 private:
  void Bytes(const std::string& name, void* bytes, size_t size) override {
    if (size == 0) return;
    if (!reads_) bytes_.resize(position_ + size);
    Require(position_ + size <= bytes_.size(), name, "is missing");
    char* const here = bytes_.data() + position_;
    std::memcpy(reads_ ? bytes : here, reads_ ? here : bytes, size);
    position_ += size;
  }
  void CheckSize(const std::string&, size_t, size_t) const override {}

  bool reads_ = false;
  std::vector<char> bytes_;
  size_t position_ = 0;
};

}  // namespace cosplat::test
