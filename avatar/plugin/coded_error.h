// An error inside the plug-in, with the status that cosplat.h returns for it.
#pragma once

#include <string>

#include "avatar/plugin/cosplat.h"
#include "splat/base/error.h"

namespace cosplat::plugin {

class CodedError : public Error {
 public:
  CodedError(cosplat_status status, const std::string& field, const std::string& problem)
      : Error(field, problem), status_(status) {}
  CodedError(cosplat_status status, const std::string& problem) : CodedError(status, "", problem) {}
  cosplat_status status() const { return status_; }

 private:
  cosplat_status status_;
};

// COSPLAT_ERROR_ARGUMENT, which most are.
[[noreturn]] inline void Refuse(const std::string& field, const std::string& problem) {
  throw CodedError(COSPLAT_ERROR_ARGUMENT, field, problem);
}

}  // namespace cosplat::plugin
