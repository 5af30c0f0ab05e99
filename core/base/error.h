/// Exceptions of the library. Tools and nodes turn them into one line and an exit code.
#pragma once

#include <stdexcept>
#include <string>

namespace edge_mcl {

/// Base class of all exceptions that edge_mcl throws on purpose.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A file or message from outside is missing, broken or contradicts another one.
/// The text names the file and the fault.
class InputError : public Error {
 public:
  using Error::Error;
};

/// A parameter is unknown, has the wrong type or has an illegal value. The text lists all faults.
class ParameterError : public Error {
 public:
  using Error::Error;
};

}  // namespace edge_mcl
