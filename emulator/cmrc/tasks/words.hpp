#pragma once
// The words that the host and the DSP programs share, by their names in c40_programs/include/*.inc: offsets on bus A,
// bits, kinds.
#include <array>
#include <functional>
#include <string_view>

#include "cmrc/tasks/job_kinds.hpp"

namespace cmrc {

struct Words {
  /// \param symbol gives the value of a symbol of the DSP image, or throws
  explicit Words(const std::function<Word(std::string_view)>& symbol);

  Word list_work_pointer, list_refresh, block_pool, block_count, block_words;
  Word x, y, t, flag, importance, link, kind, area, tick, argument, owner, generation, result, notify, slice, alive,
      slice_cycles;
  Word flag_waiting, flag_taken, flag_done;
  Word kind_count, kind_user;
  Word us_base, us_words;
  Word must_process, may_process, must_subprocess, must_trajectory, must_inverse, must_continue, end_of_leg;
  Word pid_landed, pid_locked, pid_open, pid_starved, pid_settled, pid_ramp_done, pid_began, pid_steady, pid_windy,
      torque_wind, torque_load;
  Word semaphore, semaphore_owner, semaphore_held, semaphore_list, doorbell_ring, doorbell_idle, doorbell_busy,
      fence_mask, reset_dsp;
  Word link_adapter, link_words, link_status, link_data, link_request;
  Word pide_fault, pide_late, pide_encoder, pide_following, pide_sway, pide_trip;
  Word error_of, error_tries, error_lowering, error_second, respond_place;
  Word pide_rests;
  Word cr_stopped, cr_sway_sensor, cr_path, cr_control, cr_control_block, pc_sway, cr_speed;
  Word cr_base, cr_point_period, cr_servo_period, cr_point_ticks, cr_servo_ticks, cr_leg, leg_align, cr_spreader,
      cr_load, cr_agv, cr_ramp_start, cr_clearance, cr_stretch, cr_agv_deck, cr_box_height, cr_home, cr_spot,
      cr_encoder_last, cr_encoder_total, cr_box_count, cr_box, boxes_max, bay_tiers, cr_words;
  Word ag_base, ag_words, ag_step_time, ag_point_ticks, ag_period_us, ag_unit, ag_leg, ag_produced, ag_avoid_limit,
      ag_avoid_beside, ag_segment_count, ag_segment, segments_max, segment_words, leg_words;
  Word agv_unit, agv_unit_words, agv_range, agv_range_words, range_way;

  std::array<Word, kind_rows.size()> programs{};  ///< KIND_*, by JobKind; 0xFFFFFFFF: the kind has no program

  Word program(JobKind job) const { return programs[static_cast<std::size_t>(job)]; }
  Word block(std::size_t index) const { return block_pool + static_cast<Word>(index) * block_words; }
  Word agv_area(unsigned agv) const { return ag_base + agv * ag_words; }
};

}  // namespace cmrc
