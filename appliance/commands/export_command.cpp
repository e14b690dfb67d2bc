// `deixis export`: the record as CSV or JSON lines, to a file or to standard output.
#include <cstdio>
#include <optional>

#include "appliance/calibration/whole_file.h"
#include "appliance/commands/commands.h"
#include "appliance/commands/refusal.h"
#include "appliance/exports/defect_csv.h"
#include "appliance/exports/defect_json_lines.h"
#include "appliance/records/defect_ledger.h"
#include "appliance/records/utc_time.h"

namespace deixis {
namespace {

struct ExportOptions {
    std::string database, format, output;
    std::optional<std::string> since, until, type, serial, source, state;
    QualityCodes codes;
};

Result<DefectFilter> filter_of(const ExportOptions& options) {
    DefectFilter filter;
    filter.part_type = options.type;
    filter.part_serial = options.serial;
    filter.source = options.source;
    if (options.state) filter.state = defect_state_of(*options.state);
    for (const auto& [text, time, name] : {std::tuple{&options.since, &filter.since_us, "--since"},
                                           std::tuple{&options.until, &filter.until_us, "--until"}}) {
        if (!*text) continue;
        const auto parsed = parse_utc(**text);
        if (!parsed) return fail(std::string(name) + ": " + parsed.error().sentence);
        *time = *parsed;
    }
    return filter;
}

Result<std::string> export_text(const ExportOptions& options) {
    if (const InvalidSettings complaints = options.codes.validate(); !complaints.empty())
        return fail("the " + complaints[0].key + " \"" + complaints[0].value + "\" does not fit; expected " +
                    complaints[0].range);
    const auto filter = filter_of(options);
    if (!filter) return tl::unexpected(filter.error());
    const auto ledger = DefectLedger::open_to_read(options.database);
    if (!ledger) return fail(ledger.error().sentence);
    const auto records = ledger->list(*filter);
    if (!records) return fail(records.error().sentence);
    return options.format == "csv" ? defect_csv(*records, options.codes)
                                   : defect_json_lines(*records, options.codes);
}

Result<void> export_defects(const ExportOptions& options) {
    const auto text = export_text(options);
    if (!text) return tl::unexpected(text.error());
    if (!options.output.empty()) {
        if (auto written = write_whole_file(options.output, *text); !written) return written;
        // Some file systems cannot bring a folder to disk; the file itself is there.
        (void)sync_folder(std::filesystem::path(options.output).parent_path());
        return {};
    }
    const bool written = std::fwrite(text->data(), 1, text->size(), stdout) == text->size();
    if (std::fflush(stdout) != 0 || !written)
        return fail("cannot write to standard output; give --output FILE");
    return {};
}

}  // namespace

void add_export_command(CLI::App& app) {
    static ExportOptions options;
    CLI::App* command = app.add_subcommand("export", "Write the recorded defects as CSV or JSON lines");
    command->add_option("--database", options.database, "the record (SQLite file); it is not changed")
        ->required();
    command->add_option("--format", options.format, "csv or jsonl")
        ->required()
        ->check(CLI::IsMember({"csv", "jsonl"}));
    command->add_option("--output", options.output,
                        "file to write, replaced only when complete; else standard output");
    command->add_option("--since", options.since,
                        "marked at or after, as 2026-11-22 or 2026-11-22T06:00:00Z");
    command->add_option("--until", options.until, "marked before");
    command->add_option("--type", options.type, "of this part type only");
    command->add_option("--serial", options.serial, "of this part serial only");
    command->add_option("--source", options.source, "\"live\", or the name of a replayed session");
    command->add_option("--state", options.state, "in this state only")
        ->check(CLI::IsMember({"open", "confirmed", "withdrawn"}));
    command->add_option("--fekat", options.codes.catalogue, "QM catalogue of defect types")
        ->capture_default_str();
    command->add_option("--fegrp", options.codes.code_group, "QM code group")->capture_default_str();
    command->add_option("--fecod", options.codes.code, "QM code")->capture_default_str();
    command->callback([] {
        if (const auto done = export_defects(options); !done) refuse(done.error());
    });
}

}  // namespace deixis
