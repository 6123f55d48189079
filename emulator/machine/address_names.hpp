#pragma once
// Addresses as label and offset: text that stays the same when a program moves in memory (docs/trace.md, With labels).
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "toolchain/objects/image.hpp"

namespace machine {

using toolchain::Address;

class AddressNames {
 public:
  /// Names everything in the image's sections after the nearest label before it, else after the section.
  explicit AddressNames(const toolchain::Image& image);

  /// The same, and the dock's memories: RAM on chip by the names of onchip.inc and the constants' own, the job areas by
  /// the names of areas.inc, the list by those of task_block.inc, devices by those of devices.inc.
  /// \throws std::out_of_range with the symbol's name when the image is none of a dock's DSPs.
  static AddressNames of_dock(const toolchain::Image& image);

  /// "kernel_pid", "kernel_pid+0x1A", "AG1.AG_POINT+0x2"; none where nothing has a name.
  std::optional<std::string> name(Address address) const;

  /// The address of a label, by the text that name() gives it; none: there is no such label.
  std::optional<Address> address(std::string_view label) const;

  /// As name(), else eight hexadecimal digits.
  std::string text(Address address) const;

 private:
  struct Region {
    std::string name;
    Address words = 0;
    std::map<Address, std::string> labels;  ///< by address; an empty one ends what the one before stands for
  };
  /// Of the names of one address the first in the alphabet counts.
  Region& add(std::string name, Address base, Address words);
  std::map<Address, Region> regions_;  ///< by first address; they do not overlap
};

}  // namespace machine
