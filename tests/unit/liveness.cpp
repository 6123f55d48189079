// Signs of life; refreshes.
#include "cmrc/host/liveness.hpp"

#include <doctest/doctest.h>

#include <cstdint>
#include <initializer_list>
#include <string>

namespace {

/// "3 silent, 15 dead"
std::string judged(cmrc::Liveness& liveness, std::int64_t refresh) {
  std::string all;
  for (const auto& [slot, verdict] : liveness.judge(refresh, 10)) {
    all += (all.empty() ? "" : ", ") + std::to_string(slot) +
           (verdict == cmrc::Liveness::Verdict::silent ? " silent" : " dead");
  }
  return all;
}

}  // namespace

// Silent is who has given no sign for more than the limit; reset, it has the same time again; then it is dead.
TEST_CASE("signs of life just before, at and after the limit") {
  for (const std::int64_t last : {9, 10, 11}) {
    CAPTURE(last);
    cmrc::Liveness liveness;
    liveness.sign(3, last);
    CHECK(liveness.doubtful(20, 10) == (last == 9));
    CHECK(judged(liveness, 20) == (last == 9 ? "3 silent" : ""));
  }
  cmrc::Liveness liveness;
  liveness.signs(1U << 3 | 1U << 15, 0);
  CHECK(judged(liveness, 10).empty());
  CHECK(judged(liveness, 11) == "3 silent, 15 silent");
  liveness.sign(15, 15);  // back after its reset
  CHECK(judged(liveness, 21).empty());
  CHECK(judged(liveness, 22) == "3 dead");
  CHECK(judged(liveness, 25).empty());
  CHECK(judged(liveness, 26) == "15 silent");
  CHECK(judged(liveness, 100) == "15 dead");
  CHECK_FALSE(liveness.doubtful(1000, 10));  // nobody waits for them
  liveness.signs(1U << 3, 1000);             // a board that was put in
  CHECK(judged(liveness, 1010).empty());
  CHECK(judged(liveness, 1011) == "3 silent");
}

TEST_CASE("a DSP that the host has reset has the whole time to come back") {
  cmrc::Liveness liveness;
  liveness.sign(0, 0);
  liveness.renewed(0, 8);
  CHECK(judged(liveness, 18).empty());
  CHECK_FALSE(liveness.doubtful(18, 10));
  CHECK(liveness.doubtful(19, 10));
  CHECK(judged(liveness, 19) == "0 dead");
}
