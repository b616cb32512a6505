#include "furrow/status.h"

#include <cstdarg>
#include <cstdio>

namespace furrow {

Status Status::error(StatusCode code, const char* format, ...) {
  Status status;
  status.code = code;
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(status.message, kMessageSize, format, arguments);
  va_end(arguments);
  return status;
}

}  // namespace furrow
