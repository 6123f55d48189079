#pragma once
/// An object with state lists its state once, in a member function list_state:
///
///     list("time", time_); list("ports", ports_);
///
/// This list serves to save, load, compare and hash the state. Aggregates need no list: all their members are state.
/// Pointers and references are not state; a class that has some lists its other members. Nor are temporary values,
/// observers, what follows from the configuration alone, and derived values: loading computes these again.
///
/// A list that is only read changes nothing, so a const object can be saved.
#include <array>
#include <chrono>
#include <cstddef>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "state/members.hpp"

namespace state {

/// The bytes to load are not a state of this object. The message names the place and what was found there.
class StateError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class Visitor;

template <class T>
concept Lists = requires(T& object, Visitor& list) { object.list_state(list); };

namespace detail {
template <class T>
inline constexpr bool is_array = false;
template <class T, std::size_t n>
inline constexpr bool is_array<std::array<T, n>> = true;

template <class T>
inline constexpr bool is_duration = false;
template <class Rep, class Period>
inline constexpr bool is_duration<std::chrono::duration<Rep, Period>> = true;

/// The value is its bytes: no padding, no pointer, nothing that is owned.
template <class T>
constexpr bool plain();
template <class Tuple>
inline constexpr bool all_plain = false;
template <class... T>
inline constexpr bool all_plain<std::tuple<T&...>> = (plain<T>() && ...);

__extension__ using Wide = __int128;

template <class T>
constexpr bool plain() {
  if constexpr (std::is_same_v<T, Wide>)
    return true;
  else if constexpr (std::is_same_v<T, long double> || std::is_pointer_v<T> || Lists<T>)
    return false;
  else if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>)
    return true;
  else if constexpr (is_array<T>)
    return plain<typename T::value_type>();
  else if constexpr (is_duration<T>)
    return plain<typename T::rep>();  // only the ticks
  else if constexpr (std::is_aggregate_v<T> && std::is_trivially_copyable_v<T> && !std::is_empty_v<T>)
    return std::has_unique_object_representations_v<T> && all_plain<decltype(members(std::declval<T&>()))>;
  else
    return false;
}
}  // namespace detail

class Visitor {
 public:
  virtual ~Visitor() = default;

  /// A field whose object has a list of its own.
  template <class T>
  void operator()(std::string_view name, T& field) {
    listed(name);
    value(field);
    leave();
  }

  /// Rows of eight-byte doubles or integers, one after the other; in a file they take less room than the plain bytes.
  template <class T>
  void table(std::string_view name, std::span<T> numbers, std::size_t columns) {
    static_assert(sizeof(T) == 8 && detail::plain<T>());
    listed(name);
    rows(numbers.data(), numbers.size() / columns, columns);
    leave();
  }

  /// Whether the visitor sets the object's fields. Derived values then have to be computed again.
  virtual bool loads() const = 0;

 protected:
  /// A value that consists of its bytes only.
  virtual void bytes(void* data, std::size_t size) = 0;
  /// Rows of eight-byte words.
  virtual void rows(void* first, std::size_t count, std::size_t columns) { bytes(first, count * columns * 8); }
  /// The number of elements: the present one, or while loading the stored one. Each element has at least `least` bytes.
  virtual std::size_t count(std::size_t present, std::size_t least) = 0;
  /// Everything until `leave` belongs to the field of this name.
  virtual void listed(std::string_view name) = 0;
  virtual void leave() = 0;
  /// Whether the visitor visits elements and members one by one, each between `part` and `leave`.
  virtual bool wants_parts() const { return false; }
  virtual void part(std::size_t /*index*/) {}
  [[noreturn]] void refuse(const std::string& what) const { throw StateError(what); }

 private:
  template <class T>
  void element(std::size_t index, T& field) {
    enter_part(index);
    value(field);
    leave_part();
  }

  template <class T>
  void value(T& v) {
    static_assert(!std::is_const_v<T>, "a constant is not state");
    if constexpr (Lists<T>)
      v.list_state(*this);
    else if constexpr (std::is_enum_v<T> || std::is_arithmetic_v<T> || std::is_same_v<T, detail::Wide>)
      bytes(&v, sizeof v);
    else if constexpr (detail::is_array<T>)
      elements(v.data(), v.size());
    else if constexpr (std::is_aggregate_v<T> && !std::is_array_v<T>)
      aggregate(v);
    else
      other(v);
  }

  template <class T>
  void elements(T* first, std::size_t n) {
    if constexpr (detail::plain<T>())
      if (!wants_parts() || n > 4096) {
        if constexpr (sizeof(T) == 8)
          return rows(first, n, 1);
        else
          return bytes(first, n * sizeof(T));
      }
    for (std::size_t i = 0; i < n; ++i) element(i, first[i]);
  }

  template <class T>
  void aggregate(T& v) {
    if constexpr (detail::plain<T>())
      if (!wants_parts()) return bytes(&v, sizeof v);
    std::size_t index = 0;
    std::apply([&](auto&... member) { (element(index++, member), ...); }, members(v));
  }

  template <class Rep, class Period>
  void other(std::chrono::duration<Rep, Period>& v) {
    Rep ticks = v.count();
    bytes(&ticks, sizeof ticks);
    if (loads()) v = std::chrono::duration<Rep, Period>(ticks);
  }

  void other(std::string& v) {
    const std::size_t n = count(v.size(), 1);
    if (loads()) v.resize(n);
    bytes(v.data(), n);
  }

  template <class T>
  void other(std::vector<T>& v) {
    const std::size_t n = count(v.size(), detail::plain<T>() ? sizeof(T) : 1);
    if (loads()) resize(v, n);
    elements(v.data(), n);
  }
  void other(std::vector<bool>& v) {
    const std::size_t n = count(v.size(), 1);
    if (loads()) v.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      bool bit = v[i];
      element(i, bit);
      if (loads()) v[i] = bit;
    }
  }
  template <class T>
  void other(std::deque<T>& v) {
    const std::size_t n = count(v.size(), 1);
    if (loads()) resize(v, n);
    for (std::size_t i = 0; i < n; ++i) element(i, v[i]);
  }
  /// Elements that cannot be constructed alone exist already, in the same number.
  template <class Container>
  void resize(Container& v, std::size_t n) {
    if constexpr (std::is_default_constructible_v<typename Container::value_type>)
      v.resize(n);
    else if (v.size() != n)
      refuse("a list of " + std::to_string(n) + " parts instead of " + std::to_string(v.size()));
  }

  /// Whether there is a value, stored as a number of elements.
  bool one(bool there) {
    const std::size_t n = count(there ? 1 : 0, 1);
    if (n > 1) refuse("more than one value instead of one or none");
    return n == 1;
  }
  template <class T>
  void other(std::optional<T>& v) {
    const bool there = one(v.has_value());
    if (loads() && there != v.has_value()) {
      if (!there)
        v.reset();
      else if constexpr (std::is_default_constructible_v<T>)
        v.emplace();
      else
        refuse("a part that does not exist");
    }
    if (v) value(*v);
  }
  template <class T>
  void other(std::unique_ptr<T>& v) {
    const bool there = one(v != nullptr);
    if (loads() && there != (v != nullptr)) {
      if (!there)
        v.reset();
      else if constexpr (std::is_default_constructible_v<T>)
        v = std::make_unique<T>();
      else
        refuse("a part that does not exist");
    }
    if (v) value(*v);
  }

  template <class A, class B>
  void other(std::pair<A, B>& v) {
    element(0, v.first);
    element(1, v.second);
  }

  template <class K, class T, class... Rest>
  void other(std::map<K, T, Rest...>& v) {
    associative<std::pair<K, T>>(v);
  }
  template <class K, class T, class... Rest>
  void other(std::multimap<K, T, Rest...>& v) {
    associative<std::pair<K, T>>(v);
  }
  template <class K, class... Rest>
  void other(std::set<K, Rest...>& v) {
    associative<K>(v);
  }
  template <class Element, class Container>
  void associative(Container& v) {
    const std::size_t n = count(v.size(), 1);
    if (!loads()) {
      std::size_t index = 0;
      for (const auto& entry : v) {
        if constexpr (std::is_same_v<Element, typename Container::value_type>)
          element(index++, const_cast<Element&>(entry));  // only read
        else {
          enter_part(index++);
          value(const_cast<typename Element::first_type&>(entry.first));  // only read
          value(const_cast<typename Element::second_type&>(entry.second));
          leave_part();
        }
      }
      return;
    }
    v.clear();
    for (std::size_t i = 0; i < n; ++i) {
      Element entry{};
      if constexpr (std::is_same_v<Element, typename Container::value_type>)
        value(entry);
      else
        value(entry.first), value(entry.second);
      v.insert(v.end(), std::move(entry));
    }
  }
  void enter_part(std::size_t index) {
    if (wants_parts()) part(index);
  }
  void leave_part() {
    if (wants_parts()) leave();
  }

  template <class... T>
  void other(std::variant<T...>& v) {
    std::size_t index = v.index();
    bytes(&index, sizeof index);
    if (loads() && index >= sizeof...(T)) refuse("an alternative that does not exist");
    if (loads() && index != v.index()) emplace(v, index, std::index_sequence_for<T...>());
    std::visit([&](auto& alternative) { value(alternative); }, v);
  }
  template <class V, std::size_t... I>
  static void emplace(V& v, std::size_t index, std::index_sequence<I...>) {
    ((index == I ? (void)v.template emplace<I>() : void()), ...);
  }
  void other(std::monostate&) {}
};

}  // namespace state
