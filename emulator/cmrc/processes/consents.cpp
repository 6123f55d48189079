#include "cmrc/processes/consents.hpp"

#include <algorithm>

#include "state/visitor.hpp"

namespace cmrc {

Consents::Consents(const ProcessTable& table, unsigned agvs)
    : of_agv_(numbers), sources_(numbers), tokens_(std::max(agvs, 1U) * numbers * numbers) {
  for (const Process& process : table.processes) {
    of_agv_.at(process.number) = process.robot == Robots::agv;
    sources_.at(process.number) = table.sources(process.number);
  }
}

bool Consents::given(unsigned source, unsigned target, unsigned agv) const {
  return tokens_.at(place(source, target, agv)) != 0;
}

bool Consents::all(unsigned target, unsigned agv) const {
  const auto& sources = sources_.at(target);
  return !sources.empty() &&
         std::all_of(sources.begin(), sources.end(), [&](unsigned source) { return given(source, target, agv); });
}

void Consents::consume(unsigned target, unsigned agv) {
  for (const unsigned source : sources_.at(target)) {
    if (of_agv(target) && !of_agv(source)) continue;
    clear(source, target, agv);
  }
}

void Consents::list_state(state::Visitor& list) { list("tokens", tokens_); }

}  // namespace cmrc
