// Enumerations that have rows or names: each entry has its own, in order. The compiler checks it too, where the number
// of rows is compared with the last entry; an entry behind the last is noticed here.
#include <doctest/doctest.h>

#include <string_view>

#include "c40/observers/self_check.hpp"
#include "c40/peripherals/link.hpp"
#include "c40/values/types.hpp"
#include "isa/operations.hpp"
#include "machine/boards/board_device.hpp"
#include "machine/networks/network.hpp"
#include "machine/system/scripted_events.hpp"
#include "report/values/task_account.hpp"
#include "state/enumerators.hpp"

namespace {

/// name() says each enumerator's own name.
template <class Enum>
bool named_as_written() {
  return state::all_enumerators<Enum>([](Enum value, std::string_view name_in_code) {
    CAPTURE(name_in_code);
    CHECK(name(value) == name_in_code);
    return name(value) == name_in_code;
  });
}

}  // namespace

TEST_CASE("the number of rows is the number of entries") {
  CHECK(isa::operation_rows.size() == state::enumerator_count<isa::Operation>());
  CHECK(c40::cause_rows.size() == state::enumerator_count<c40::Cause>());
  CHECK(machine::scripted_actions().size() == state::enumerator_count<machine::Action>());
  CHECK(machine::device_kinds().size() + 1 == state::enumerator_count<machine::DeviceKind>());  // `own` has a class
}

TEST_CASE("an entry's name in texts is its name in the code") {
  CHECK(named_as_written<c40::Cause>());
  CHECK(named_as_written<c40::Rule>());
  CHECK(named_as_written<c40::LinkEvent::Kind>());
  CHECK(named_as_written<machine::NetworkEvent::Kind>());
  CHECK(named_as_written<machine::NetworkAction::Kind>());
  CHECK(named_as_written<machine::ChipStatus>());
  CHECK(named_as_written<machine::NetworkStop::Reason>());
  CHECK(named_as_written<report::Outcome>());
}
