#pragma once
/// Every memory-mapped register of the chip (c40-hardware.md 1.3): address, name, fields, reset value. Messages, the
/// inspection by name and docs/peripherals.md are made from this list.
#include <span>
#include <string>

#include "c40/peripherals/fields.hpp"

namespace c40 {

struct RegisterInfo {
  Address address = 0;
  std::string name;  ///< "PORT3.control"
  std::string_view meaning;
  std::span<const Field> fields;  ///< empty: the whole word is one value
  FieldAccess access = FieldAccess::read_write;
  Word reset = 0;
  std::string_view source;  ///< section of c40-hardware.md
};

/// By rising address.
std::span<const RegisterInfo> register_map();
/// Null for a reserved address.
const RegisterInfo* register_at(Address address);
/// In any case of letters. Throws std::out_of_range for one that does not exist, with the name that was likely meant.
const RegisterInfo& register_named(std::string_view name);
/// The name of a peripheral address, for messages: "PORT1.input (communication port 1)", "the analysis block".
std::string describe_register(Address address);
/// The register tables of docs/peripherals.md, as Markdown.
std::string register_page();

}  // namespace c40
