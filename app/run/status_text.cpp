// SPDX-License-Identifier: BSD-2-Clause
#include "app/run/status_text.h"

#include <fmt/core.h>

namespace facet {

std::string status_screen(const RunStatus& status, const std::string& title) {
    const FrameStatus& f = status.frame;
    const Health& h = f.health;
    const std::string reasons = reason_names(h.reasons);
    std::string text = fmt::format("facet run  {}  up {:.0f} s\n\n", title, status.uptime_s);
    text += fmt::format("state      {}{}{}, quality {}, resets {}{}\n", to_string(h.state), reasons.empty() ? "" : ": ",
                        reasons, h.quality, h.reset_counter, h.is_still ? ", standing" : "");
    text += fmt::format("rate       {:.1f} frames/s, {} used; last took {:.1f} ms; {} overruns\n", status.rate_hz,
                        f.frames, f.total_ms, status.overruns);
    text += fmt::format("latency    {:.1f} ms median, {:.1f} ms p99 (exposure midpoint to pose)\n", f.latency_median_ms,
                        f.latency_p99_ms);
    text += fmt::format("features   {} tracked, {} in stereo, {} landmarks in {} keyframes\n", h.tracked, h.stereo,
                        h.landmarks, h.keyframes);
    text += fmt::format("mesh       {} planes, {} faces\n", f.planes, f.mesh_faces);
    text += fmt::format("pose       {:.2f} {:.2f} {:.2f} m, {:.2f} m/s\n", f.p_W_B.x(), f.p_W_B.y(), f.p_W_B.z(),
                        f.speed_m_per_s);
    text += fmt::format("drops      {} late frames, {} outputs\n\n", status.late, status.outputs_dropped);
    text += fmt::format("{:<10} {:>10} {:>8} {:>8} {:>9} {:>8} {:>7} {:>10}\n", "source", "delivered", "lost",
                        "corrupt", "discarded", "rejected", "errors", "recoveries");
    for (const SourceAccount& s : status.sources) {
        const SourceCounters& c = s.counters;
        text += fmt::format("{:<10} {:>10} {:>8} {:>8} {:>9} {:>8} {:>7} {:>10}\n", s.name, c.delivered, c.lost,
                            c.corrupt, c.discarded, s.rejected, c.errors, c.recoveries);
    }
    text += "\n";
    for (const std::string& event : f.events) {
        text += event.substr(0, 110) + "\n";
    }
    return text;
}

std::string status_line(const RunStatus& status) {
    const FrameStatus& f = status.frame;
    std::uint64_t errors = 0;
    for (const SourceAccount& s : status.sources) {
        errors += s.counters.errors;
    }
    return fmt::format(
        "{} quality {}, {:.1f} frames/s, latency {:.1f}/{:.1f} ms, {} features, {} planes, {} late, {} overruns, "
        "{} source errors",
        to_string(f.health.state), f.health.quality, status.rate_hz, f.latency_median_ms, f.latency_p99_ms,
        f.health.tracked, f.planes, status.late, status.overruns, errors);
}

}  // namespace facet
