// The figures of a session, its criteria, and their two forms: table and JSON.
#include "appliance/acceptance/acceptance_report.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>

namespace deixis {

namespace {

constexpr double degrees_per_radian = 57.29577951308232;

std::string format(const char* pattern, ...) __attribute__((format(printf, 1, 2)));

std::string format(const char* pattern, ...) {
    char line[400];
    va_list arguments;
    va_start(arguments, pattern);
    std::vsnprintf(line, sizeof line, pattern, arguments);
    va_end(arguments);
    return line;
}

double mean_corner_displacement(const Box& box, const RigidTransform& a, const RigidTransform& b) {
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const Eigen::Vector3d p((corner & 1) != 0 ? box.max.x() : box.min.x(),
                                (corner & 2) != 0 ? box.max.y() : box.min.y(),
                                (corner & 4) != 0 ? box.max.z() : box.min.z());
        sum += (a * p - b * p).norm();
    }
    return sum / 8;
}

PartPoseFigures part_figures(const Truth& truth, const Results& results, const std::optional<Box>& part_box) {
    PartPoseFigures figures;
    std::vector<double> origin_mm, rotation_deg, corner_mm;
    for (const ResultFrame& frame : results.frames) {
        const TruthPartPose pose = part_pose_at(truth, frame.timestamp_us);
        if (!pose.rotation && !pose.translation) continue;
        ++figures.frames_with_truth;
        if (!frame.part || !frame.part->world_from_part) continue;
        ++figures.frames_tracking;
        const RigidTransform& found = *frame.part->world_from_part;
        if (pose.translation) origin_mm.push_back(1e3 * (found.translation - *pose.translation).norm());
        if (pose.rotation) {
            const RigidTransform turned{*pose.rotation, found.translation};
            rotation_deg.push_back(degrees_per_radian * rotation_between(found, turned));
        }
        if (pose.rotation && pose.translation && part_box) {
            corner_mm.push_back(1e3 *
                                mean_corner_displacement(*part_box, found,
                                                         RigidTransform{*pose.rotation, *pose.translation}));
        }
    }
    figures.origin_mm = summarise(std::move(origin_mm));
    figures.rotation_deg = summarise(std::move(rotation_deg));
    figures.corner_mm = summarise(std::move(corner_mm));
    return figures;
}

/// Collects the sentences of criteria that are not met.
class Criteria {
  public:
    void at_most(const char* key, const std::optional<double>& limit, double value, bool known) {
        if (!limit) return;
        if (!known)
            failures.push_back(std::string(key) + " cannot be judged: there is no data for it");
        else if (!(value <= *limit))
            failures.push_back(format("%s is %.2f, allowed %.2f", key, value, *limit));
    }

    void at_least(const char* key, const std::optional<double>& limit, double value, bool known) {
        if (!limit) return;
        if (!known)
            failures.push_back(std::string(key) + " cannot be judged: there is no data for it");
        else if (!(value >= *limit))
            failures.push_back(format("%s is %.3f, demanded %.3f", key, value, *limit));
    }

    std::vector<std::string> failures;
};

std::vector<std::string> failures_of(const AcceptanceReport& report, const Expected& expected) {
    Criteria criteria;
    const double meant = double(report.marks.meant_holds());
    const double right = double(report.marks.count(HoldVerdict::right));
    criteria.at_least("marks_found_min", expected.marks_found_min, meant > 0 ? right / meant : 0, meant > 0);
    criteria.at_most("false_marks_max", expected.false_marks_max, double(report.marks.false_marks()), true);
    const SampleSummary& position = report.position_mm;
    criteria.at_most("position_mm_median_max", expected.position_mm_median_max, position.median,
                     position.count > 0);
    criteria.at_most("position_mm_p95_max", expected.position_mm_p95_max, position.p95, position.count > 0);
    criteria.at_most("joint_error_mm_max", expected.joint_error_mm_max, 0, false);
    criteria.at_least("pcp_min", expected.pcp_min, 0, false);
    const PartPoseFigures& part = report.part;
    criteria.at_most("part_mm_max", expected.part_mm_max, part.origin_mm.max, part.origin_mm.count > 0);
    criteria.at_most("part_deg_max", expected.part_deg_max, part.rotation_deg.max,
                     part.rotation_deg.count > 0);
    criteria.at_most("frame_ms_p99_max", expected.frame_ms_p99_max, report.frame_ms.p99,
                     report.frame_ms.count > 0);
    return criteria.failures;
}

void demand_every_mark(const MarkMatch& marks, std::vector<std::string>& failures) {
    const size_t meant = marks.meant_holds(), right = marks.count(HoldVerdict::right);
    if (right != meant)
        failures.push_back(
            format("%zu of %zu meant gestures are exactly one mark in its place", right, meant));
    if (marks.false_marks() > 0) failures.push_back(format("%zu false marks", marks.false_marks()));
}

std::string hold_row(const JudgedHold& hold, const std::vector<JudgedMark>& marks) {
    const TruthHold& truth = hold.truth;
    const std::string spot = truth.target_part ? format("%7.3f %7.3f %7.3f", truth.target_part->x(),
                                                        truth.target_part->y(), truth.target_part->z())
                                               : "      -       -       -";
    std::string marked = "      -       -       -";
    if (!hold.marks.empty()) {
        const Eigen::Vector3d& p = marks[hold.marks.front()].mark.position_part;
        marked = format("%7.3f %7.3f %7.3f", p.x(), p.y(), p.z());
    }
    const std::string distance = hold.distance_m ? format("%6.0f", 1e3 * *hold.distance_m) : "     -";
    const char* verdict = !truth.meant ? "trap" : name_of(hold.verdict);
    const char* arm = truth.arm ? (*truth.arm == ArmSide::left ? "left" : "right") : "?";
    const char* arm_note = hold.arm_right && !*hold.arm_right ? " (other arm)" : "";
    return format("%4lld  %-5s  %-5s  %7.2f  %s  %s  %s  %s%s\n", static_cast<long long>(truth.hold), arm,
                  truth.touch ? "touch" : "far", double(truth.first_us) * 1e-6, spot.c_str(), marked.c_str(),
                  distance.c_str(), verdict, arm_note);
}

nlohmann::ordered_json to_json(const SampleSummary& summary) {
    if (summary.count == 0) return {{"count", 0}};
    return {{"count", summary.count},
            {"median", summary.median},
            {"p95", summary.p95},
            {"p99", summary.p99},
            {"max", summary.max}};
}

nlohmann::ordered_json to_json(const Eigen::Vector3d& v) {
    return {v.x(), v.y(), v.z()};
}

nlohmann::ordered_json to_json(const JudgedHold& hold) {
    nlohmann::ordered_json out = {{"hold", hold.truth.hold},
                                  {"meant", hold.truth.meant},
                                  {"first_us", hold.truth.first_us},
                                  {"last_us", hold.truth.last_us},
                                  {"marks", hold.marks.size()}};
    if (hold.truth.target_part) out["target_part"] = to_json(*hold.truth.target_part);
    if (hold.distance_m) out["distance_mm"] = 1e3 * *hold.distance_m;
    if (hold.arm_right) out["arm_right"] = *hold.arm_right;
    out["verdict"] = hold.truth.meant ? name_of(hold.verdict) : "trap";
    return out;
}

nlohmann::ordered_json to_json(const JudgedMark& mark) {
    nlohmann::ordered_json out = {{"id", mark.mark.id},
                                  {"timestamp_us", mark.timestamp_us},
                                  {"position_part", to_json(mark.mark.position_part)},
                                  {"verdict", name_of(mark.verdict)}};
    if (mark.distance_m) out["distance_mm"] = 1e3 * *mark.distance_m;
    return out;
}

}  // namespace

SampleSummary summarise(std::vector<double> samples) {
    SampleSummary summary;
    summary.count = samples.size();
    if (samples.empty()) return summary;
    std::sort(samples.begin(), samples.end());
    const auto rank = [&](double share) {
        const auto nearest = static_cast<size_t>(std::ceil(share * double(samples.size())));
        return samples[std::clamp<size_t>(nearest, 1, samples.size()) - 1];
    };
    summary.median = rank(0.5);
    summary.p95 = rank(0.95);
    summary.p99 = rank(0.99);
    summary.max = samples.back();
    return summary;
}

AcceptanceReport judge_session(const Truth& truth, const Results& results, const Demands& demands,
                               const std::optional<Box>& part_box, const MarkMatchingParams& params) {
    AcceptanceReport report;
    report.marks = match_marks(truth, results, params);
    std::vector<double> position_mm, frame_ms;
    for (const JudgedHold& hold : report.marks.holds) {
        if (hold.distance_m) position_mm.push_back(1e3 * *hold.distance_m);
        if (!hold.arm_right) continue;
        ++report.arms_known;
        if (*hold.arm_right) ++report.arms_right;
    }
    for (const ResultFrame& frame : results.frames) {
        const auto total = frame.stage_ms.find("total");
        if (total != frame.stage_ms.end()) frame_ms.push_back(total->second);
    }
    report.position_mm = summarise(std::move(position_mm));
    report.frame_ms = summarise(std::move(frame_ms));
    report.part = part_figures(truth, results, part_box);
    if (demands.expected) report.failures = failures_of(report, *demands.expected);
    if (demands.every_mark) demand_every_mark(report.marks, report.failures);
    return report;
}

std::string table_of(const AcceptanceReport& report) {
    const MarkMatch& match = report.marks;
    std::string out =
        "hold  arm    kind    at [s]  true spot [m]            mark [m]                 off mm  verdict\n";
    for (const JudgedHold& hold : match.holds) out += hold_row(hold, match.marks);
    for (const JudgedMark& mark : match.marks) {
        if (mark.verdict != MarkVerdict::false_mark) continue;
        const Eigen::Vector3d& p = mark.mark.position_part;
        out +=
            format("   -  false mark %lld at %.2f s: %.3f %.3f %.3f\n", static_cast<long long>(mark.mark.id),
                   double(mark.timestamp_us) * 1e-6, p.x(), p.y(), p.z());
    }
    out += format("\nmeant gestures   %zu: %zu right, %zu missed, %zu doubled, %zu too far; traps %zu\n",
                  match.meant_holds(), match.count(HoldVerdict::right), match.count(HoldVerdict::missed),
                  match.count(HoldVerdict::doubled), match.count(HoldVerdict::too_far),
                  match.holds.size() - match.meant_holds());
    out += format("marks            %zu: %zu false; arm right in %zu of %zu\n", match.marks.size(),
                  match.false_marks(), report.arms_right, report.arms_known);
    const auto row = [&](const char* label, const SampleSummary& s, const char* unit) {
        if (s.count == 0) return;
        out += format("%-16s median %.2f, p95 %.2f, p99 %.2f, max %.2f %s over %zu\n", label, s.median, s.p95,
                      s.p99, s.max, unit, s.count);
    };
    row("mark position", report.position_mm, "mm");
    if (report.part.frames_with_truth > 0) {
        out += format("part             tracking in %zu of %zu frames\n", report.part.frames_tracking,
                      report.part.frames_with_truth);
    }
    row("part origin", report.part.origin_mm, "mm");
    row("part rotation", report.part.rotation_deg, "degrees");
    row("part corners", report.part.corner_mm, "mm");
    row("frame", report.frame_ms, "ms");
    for (const std::string& failure : report.failures) out += "NOT MET          " + failure + "\n";
    if (report.failures.empty()) out += "accepted\n";
    return out;
}

nlohmann::ordered_json to_json(const AcceptanceReport& report) {
    nlohmann::ordered_json out;
    const MarkMatch& match = report.marks;
    out["accepted"] = report.failures.empty();
    out["failures"] = report.failures;
    out["meant"] = match.meant_holds();
    out["right"] = match.count(HoldVerdict::right);
    out["missed"] = match.count(HoldVerdict::missed);
    out["doubled"] = match.count(HoldVerdict::doubled);
    out["too_far"] = match.count(HoldVerdict::too_far);
    out["traps"] = match.holds.size() - match.meant_holds();
    out["marks"] = match.marks.size();
    out["false_marks"] = match.false_marks();
    out["arms_known"] = report.arms_known;
    out["arms_right"] = report.arms_right;
    out["position_mm"] = to_json(report.position_mm);
    out["part"] = {{"frames_with_truth", report.part.frames_with_truth},
                   {"frames_tracking", report.part.frames_tracking},
                   {"origin_mm", to_json(report.part.origin_mm)},
                   {"rotation_deg", to_json(report.part.rotation_deg)},
                   {"corner_mm", to_json(report.part.corner_mm)}};
    out["frame_ms"] = to_json(report.frame_ms);
    for (const JudgedHold& hold : match.holds) out["holds"].push_back(to_json(hold));
    for (const JudgedMark& mark : match.marks) out["judged_marks"].push_back(to_json(mark));
    return out;
}

}  // namespace deixis
