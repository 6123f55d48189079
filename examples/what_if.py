"""What would have happened, had DSP 1 not failed? Two futures of one past (docs/snapshots.md)."""

import cmrc

run = cmrc.Simulation(preset="saturated", dsps=3, duration_s=1.0)
run.run_until(0.5)
without = run.fork()
run.at(0.5, "fail", dsp=1)

for name, future in (("DSP 1 fails at 0.5 s", run), ("it does not fail", without)):
    result = future.run()
    servo = result.rates["f_p"]["realised_hz"]
    error_mm = 1000 * result.errors["load_m"]["rms"]
    print(f"{name:20} {result.misses:6} deadlines missed, f_p {servo:6.1f} Hz, load {error_mm:8.3f} mm RMS off")
