#pragma once
// Addresses as label and offset: text that does not change when a program moves in memory (docs/trace.md, With labels).
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "toolchain/objects/image.hpp"

namespace machine {

using toolchain::Address;

class AddressNames {
 public:
  /// Names each address in the image's sections by the nearest label before it, else by its section.
  explicit AddressNames(const toolchain::Image& image);

  /// The same, with the dock's memories: RAM on chip by the names of onchip.inc and of the constants, the job areas by
  /// the names of areas.inc, the list by those of task_block.inc, devices by those of devices.inc.
  /// \throws std::out_of_range with the symbol's name if the image is not a program of the dock's DSPs.
  static AddressNames of_dock(const toolchain::Image& image);

  /// "kernel_pid", "kernel_pid+0x1A", "AG1.AG_POINT+0x2"; none if the address has no name.
  std::optional<std::string> name(Address address) const;

  /// The address of a label in the form of name(); none if there is no such label.
  std::optional<Address> address(std::string_view label) const;

  /// The result of name(), else eight hexadecimal digits.
  std::string text(Address address) const;

 private:
  struct Region {
    std::string name;
    Address words = 0;
    std::map<Address, std::string> labels;  ///< by address; an empty label ends the range of the one before
  };
  /// If one address has several names, the first in the alphabet is used.
  Region& add(std::string name, Address base, Address words);
  std::map<Address, Region> regions_;  ///< by first address; they do not overlap
};

}  // namespace machine
