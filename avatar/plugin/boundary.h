// The library's boundary: runs the body of a function of cosplat.h and turns exceptions into a
// status.
#pragma once

#include <new>
#include <stdexcept>

#include "avatar/plugin/coded_error.h"
#include "avatar/plugin/handle_table.h"

namespace cosplat::plugin {

// Stores the text for cosplat_last_error, for this thread and, unless null, for the instance.
cosplat_status Fail(cosplat_status status, const char* text, Instance* instance) noexcept;

// The last error text of this thread; "" before the first failure.
const char* LastErrorOfThread() noexcept;

// Calls body() and turns its exceptions into a status and a text. error_status: the status for an
// Error that carries none.
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

// The avatar, locked for this thread until it calls Leave. Throws CodedError when the handle is
// invalid or in use.
std::shared_ptr<Instance> Enter(cosplat_avatar* avatar);

// Guard and Enter for the functions that take a handle: calls body(instance).
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
