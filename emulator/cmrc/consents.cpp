#include "cmrc/consents.hpp"

#include <span>
#include <stdexcept>

namespace cmrc {
namespace {

std::span<const unsigned> sources(unsigned target) {
  static constexpr unsigned grab[] = {2, 4}, load[] = {3, 6}, crane_home[] = {1, 4}, agv_home[] = {1, 5};
  switch (target) {
    case 3: return grab;
    case 4: return load;
    case 7: return crane_home;
    case 8: return agv_home;
    default: throw std::logic_error("Consents: processes 1, 2, 5, 6 are loaded by demand, not by consent");
  }
}

}  // namespace

Consents::Consents(unsigned agvs) : tokens_(agvs) {}

void Consents::give(unsigned source, unsigned target, unsigned agv) {
  tokens_.at(of_agv(source, target) ? agv : 0).at(source).at(target) = true;
}

void Consents::clear(unsigned source, unsigned target, unsigned agv) {
  tokens_.at(of_agv(source, target) ? agv : 0).at(source).at(target) = false;
}

bool Consents::given(unsigned source, unsigned target, unsigned agv) const {
  return tokens_.at(of_agv(source, target) ? agv : 0).at(source).at(target);
}

bool Consents::all(unsigned target, unsigned agv) const {
  for (const unsigned source : sources(target)) {
    if (!given(source, target, agv)) return false;
  }
  return true;
}

void Consents::consume(unsigned target, unsigned agv) {
  for (const unsigned source : sources(target)) {
    // "The job is done" (1 to 8) holds for every AGV.
    if (source == 1 && target == 8) continue;
    clear(source, target, agv);
  }
}

}  // namespace cmrc
