/// Keeps what libraries write to std::cerr.
#pragma once

#include <iostream>
#include <mutex>
#include <streambuf>
#include <string>

namespace edge_mcl {

/// Takes over std::cerr while it exists. Libraries report an unreadable file there, and the tool
/// reports it too, in one line of its own on C's stderr. So their text is kept and printed only
/// when the tool ends with an internal error.
class LibraryMessages : public std::streambuf {
 public:
  LibraryMessages() : before_(std::cerr.rdbuf(this)) {}
  ~LibraryMessages() override { std::cerr.rdbuf(before_); }
  LibraryMessages(const LibraryMessages&) = delete;
  LibraryMessages& operator=(const LibraryMessages&) = delete;

  /// The last 8 KiB.
  std::string text() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return text_;
  }

 protected:
  int_type overflow(int_type c) override {
    const char letter = traits_type::to_char_type(c);
    if (!traits_type::eq_int_type(c, traits_type::eof())) xsputn(&letter, 1);
    return traits_type::not_eof(c);
  }
  std::streamsize xsputn(const char* text, std::streamsize count) override {
    constexpr size_t kKept = 8192;  // some hundred lines, enough for a report
    const std::lock_guard<std::mutex> lock(mutex_);
    text_.append(text, static_cast<size_t>(count));
    if (text_.size() > kKept) text_.erase(0, text_.size() - kKept);
    return count;
  }

 private:
  std::streambuf* before_;
  mutable std::mutex mutex_;
  std::string text_;
};

}  // namespace edge_mcl
