#pragma once
// Values as bytes, from a child process to its parent: read in the order in which they were put.
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace cmrc {

class Bytes {
 public:
  template <class Item>
    requires std::is_trivially_copyable_v<Item>
  void put(const Item& item) {
    text_.append(reinterpret_cast<const char*>(&item), sizeof item);
  }
  template <class Item>
  void put(const std::vector<Item>& items) {
    put(static_cast<std::uint64_t>(items.size()));
    text_.append(reinterpret_cast<const char*>(items.data()), items.size() * sizeof(Item));
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

class BytesReader {
 public:
  explicit BytesReader(std::string_view text) : text_(text) {}

  template <class Item>
  Item take() {
    Item item{};
    copy(&item, sizeof item);
    return item;
  }
  template <class Item>
  std::vector<Item> list() {
    std::vector<Item> items(take<std::uint64_t>());
    copy(items.data(), items.size() * sizeof(Item));
    return items;
  }

 private:
  void copy(void* to, std::size_t size) {
    if (size > text_.size()) throw std::logic_error("BytesReader: fewer bytes than were put");
    text_.copy(static_cast<char*>(to), size);  // not std::memcpy: an empty list has no place to copy to
    text_.remove_prefix(size);
  }

  std::string_view text_;
};

}  // namespace cmrc
