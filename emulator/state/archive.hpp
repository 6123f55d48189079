#pragma once
/// State as bytes, and back. A hash of each field's name precedes the field, so that a state with another list is
/// refused with the name of the first field that differs.
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "state/columns.hpp"
#include "state/visitor.hpp"

namespace state {

/// A saved state, and the places of long tables in it.
struct Saved {
  std::string text;
  std::vector<Table> tables;
};

class Saver : public Visitor {
 public:
  bool loads() const override { return false; }
  const std::string& text() const { return text_; }
  std::string take() { return std::move(text_); }
  std::vector<Table> take_tables() { return std::move(tables_); }
  /// Reserves memory for this number of bytes, so that a state of tens of megabytes is not moved while it grows.
  void expect(std::size_t bytes) { text_.reserve(bytes); }

 protected:
  void bytes(void* data, std::size_t size) override;
  void rows(void* first, std::size_t count, std::size_t columns) override;
  std::size_t count(std::size_t present, std::size_t least) override;
  void listed(std::string_view name) override;
  void leave() override {}

 private:
  std::string text_;
  std::vector<Table> tables_;
};

class Loader : public Visitor {
 public:
  /// \param puts_back what an object was before a load that failed
  explicit Loader(std::string_view text, bool puts_back = false) : rest_(text), puts_back_(puts_back) {}
  bool loads() const override { return true; }
  /// What takes a state from elsewhere, and refuses this one too, stays as it is: all else is put back.
  bool puts_back() const { return puts_back_; }
  /// \throws StateError when something is left
  void end() const;

 protected:
  void bytes(void* data, std::size_t size) override;
  std::size_t count(std::size_t present, std::size_t least) override;
  void listed(std::string_view name) override;
  void leave() override { path_.pop_back(); }

 private:
  [[noreturn]] void refuse_here(const std::string& what) const;
  std::string_view rest_;
  bool puts_back_;
  std::vector<std::string_view> path_;
};

/// A value in a saved state: "buses.0.ports.1.wanted", and the place of its bytes.
struct Leaf {
  std::string path;
  std::size_t offset = 0, size = 0;
};

/// Saves, and notes the place of each value.
class Lister final : public Saver {
 public:
  const std::vector<Leaf>& leaves() const { return leaves_; }

 protected:
  bool wants_parts() const override { return true; }
  void bytes(void* data, std::size_t size) override;
  std::size_t count(std::size_t present, std::size_t least) override;
  void listed(std::string_view name) override;
  void part(std::size_t index) override;
  void leave() override;

 private:
  void add(std::string_view name);
  std::string path_;
  std::vector<std::size_t> ends_;
  std::vector<Leaf> leaves_;
};

/// \param expected number of bytes, if known
template <class T>
Saved save_with_tables(const T& object, std::size_t expected = 0) {
  Saver saver;
  saver.expect(expected);
  const_cast<T&>(object).list_state(saver);  // a saver only reads
  return {saver.take(), saver.take_tables()};
}
template <class T>
std::string save(const T& object) {
  return save_with_tables(object).text;
}

/// \throws StateError; after that the object must not be used
template <class T>
void load(T& object, std::string_view text) {
  Loader loader(text);
  object.list_state(loader);
  loader.end();
}

/// The same; after an exception the object is as before.
template <class T>
void load_or_leave(T& object, std::string_view text) {
  const std::string before = save(object);
  try {
    load(object, text);
  } catch (...) {  // a device of Python's raises anything
    Loader loader(before, true);
    object.list_state(loader);
    throw;
  }
}

/// A value without a list of its own: anything that a visitor takes as a field.
template <class T>
std::string save_value(const T& value) {
  Saver saver;
  saver("value", const_cast<T&>(value));  // a saver only reads
  return saver.take();
}

/// \throws StateError
template <class T>
T load_value(std::string_view text) {
  T value{};
  Loader loader(text);
  loader("value", value);
  loader.end();
  return value;
}

/// The first value that differs between two states, as "path: 1F00 beside 2000" (bytes, hexadecimal); none if the
/// states are equal.
std::optional<std::string> first_difference(const Lister& a, const Lister& b);

template <class T>
std::optional<std::string> difference(const T& a, const T& b) {
  Lister of_a, of_b;
  const_cast<T&>(a).list_state(of_a);  // a lister only reads
  const_cast<T&>(b).list_state(of_b);  // NOLINT
  return first_difference(of_a, of_b);
}

}  // namespace state
