// What the doctor found: one line a check, with what to do about it.
#pragma once

#include <string>
#include <vector>

namespace deixis {

enum class DoctorVerdict { ok, warn, fail };

struct DoctorLine {
    DoctorVerdict verdict = DoctorVerdict::ok;
    std::string subject;  ///< "sensor drivers", "record", "disk"...
    std::string finding;  ///< one sentence
    std::string advice;   ///< what to do; empty when all is well
};

class DoctorReport {
  public:
    void ok(const std::string& subject, const std::string& finding);
    void warn(const std::string& subject, const std::string& finding, const std::string& advice);
    void fail(const std::string& subject, const std::string& finding, const std::string& advice);

    const std::vector<DoctorLine>& lines() const { return lines_; }
    bool failed() const;

    /// "OK    subject: finding" and, indented, the advice.
    std::string text() const;

    /// {"ok": bool, "checks": [{"verdict", "subject", "finding", "advice"}]}
    std::string json() const;

  private:
    std::vector<DoctorLine> lines_;
};

}  // namespace deixis
