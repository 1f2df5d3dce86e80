// The edge of the library: what runs inside one function of cosplat.h, and how it ends.
#pragma once

#include <new>
#include <stdexcept>

#include "avatar/plugin/coded_error.h"
#include "avatar/plugin/handle_table.h"

namespace cosplat::plugin {

// Keeps the text for cosplat_last_error of this thread and, unless null, of the instance.
cosplat_status Fail(cosplat_status status, const char* text, Instance* instance) noexcept;

// Of this thread; "" before the first failure.
const char* LastErrorOfThread() noexcept;

// body(); its exceptions become a status and a text. error_status: of Error that has no status.
template <class Body>
cosplat_status Guard(Instance* instance, cosplat_status error_status, const Body& body) noexcept {
  try {
    body();
    return COSPLAT_OK;
  } catch (const CodedError& error) {
    return Fail(error.status(), error.what(), instance);
  } catch (const Error& error) {
    return Fail(error_status, error.what(), instance);
  } catch (const std::bad_alloc&) {
    return Fail(COSPLAT_ERROR_MEMORY, "not enough memory", instance);
  } catch (const std::length_error&) {
    return Fail(COSPLAT_ERROR_MEMORY, "not enough memory", instance);
  } catch (const std::exception& error) {
    return Fail(COSPLAT_ERROR_INTERNAL, error.what(), instance);
  } catch (...) {
    return Fail(COSPLAT_ERROR_INTERNAL, "an unknown exception", instance);
  }
}

// The avatar, for this thread alone until it calls Leave. Throws CodedError when the handle is
// wrong or in use.
std::shared_ptr<Instance> Enter(cosplat_avatar* avatar);

// body(instance), for the functions that take a handle.
template <class Body>
cosplat_status WithAvatar(cosplat_avatar* avatar, const Body& body) noexcept {
  std::shared_ptr<Instance> instance;
  cosplat_status status = Guard(nullptr, COSPLAT_ERROR_INTERNAL, [&] { instance = Enter(avatar); });
  if (status != COSPLAT_OK) return status;
  status = Guard(instance.get(), COSPLAT_ERROR_INTERNAL, [&] { body(*instance); });
  instance->Leave();
  return status;
}

}  // namespace cosplat::plugin
