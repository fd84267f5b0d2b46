// SPDX-License-Identifier: Apache-2.0
// A value or the reason why there is none, with the member names of std::expected.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

namespace handover {

/// Codes by what the caller can do next; the detail is for people only.
enum class ErrorCode {
  kInvalidInput,  ///< a file, field or request is wrong; the detail names it
  kNotFound,      ///< a name, file or entry does not exist
  kUnreachable,   ///< no configuration within limits reaches the pose
  kInCollision,   ///< every configuration that reaches touches something
  kNoPath,        ///< the search budget ended without a path
  kDeadline,      ///< the deadline passed
  kCancelled,     ///< the request was cancelled
  kIo,            ///< reading or writing failed
  kInternal,      ///< a promise of our own was broken
};

struct Error {
  ErrorCode code = ErrorCode::kInternal;
  std::string detail;

  bool operator==(const Error&) const = default;
};

/// Thrown where value() is asked of an error.
class BadResultAccess : public std::logic_error {
 public:
  explicit BadResultAccess(const Error& error) : std::logic_error("no value: " + error.detail) {}
};

template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::move(value)) {}  // NOLINT(google-explicit-constructor)

  Result(Error error) : state_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

  Result(ErrorCode code, std::string detail) : state_(Error{code, std::move(detail)}) {}

  bool has_value() const { return std::holds_alternative<T>(state_); }

  explicit operator bool() const { return has_value(); }

  const T& value() const& {
    if (!has_value()) throw BadResultAccess(error());
    return std::get<T>(state_);
  }

  T& value() & {
    if (!has_value()) throw BadResultAccess(error());
    return std::get<T>(state_);
  }

  T&& value() && {
    if (!has_value()) throw BadResultAccess(error());
    return std::get<T>(std::move(state_));
  }

  const T& operator*() const& { return value(); }

  T& operator*() & { return value(); }

  const T* operator->() const { return &value(); }

  T* operator->() { return &value(); }

  const Error& error() const { return std::get<Error>(state_); }

 private:
  std::variant<T, Error> state_;
};

/// Done, or the reason why not.
template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;  ///< done

  Result(Error error) : error_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

  Result(ErrorCode code, std::string detail) : error_(Error{code, std::move(detail)}) {}

  bool has_value() const { return !error_.has_value(); }

  explicit operator bool() const { return has_value(); }

  /// @pre !has_value().
  const Error& error() const { return *error_; }

 private:
  std::optional<Error> error_;
};

}  // namespace handover
