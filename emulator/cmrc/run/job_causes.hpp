#pragma once
// The causes in a job's account: those of the chip, with the waits at the two windows apart.
#include <string>
#include <vector>

#include "cmrc/measures/ledger.hpp"

namespace machine {
struct Config;
class Machine;
}  // namespace machine

namespace cmrc {

struct Config;

/// The chip's causes, by c40::Cause.
std::vector<std::string> cause_names();
/// A job's causes distinguish the two windows: A's are at the chip's places, B's come after them.
std::vector<std::string> job_causes();
/// The causes of a slot's chip until now, in the order of job_causes().
CauseTimes job_causes(const machine::Machine& machine, unsigned slot);

LedgerConfig ledger_of(const Config& config, const machine::Config& machine);

}  // namespace cmrc
