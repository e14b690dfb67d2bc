// The doctor's checks, each on one thing that a station needs. They look and never change anything.
#pragma once

#include <filesystem>
#include <string>

#include "appliance/commands/doctor_report.h"
#include "appliance/station/settings.h"

namespace deixis {

/// OpenNI2 and its driver plug-ins, by their files: the doctor does not load them, no more than the station
/// does. `driver_folder` empty: the system's library folders.
void check_drivers(DoctorReport& report, const std::filesystem::path& driver_folder);

/// Depth sensors on USB and whether this user may open them. `sysfs` and `devices` are "/sys" and "/dev".
void check_usb(DoctorReport& report, const std::filesystem::path& sysfs,
               const std::filesystem::path& devices);

/// A session folder: manifest, streams with checksums, calibration, part and its model.
void check_session(DoctorReport& report, const std::filesystem::path& folder, const ModelReader& reader);

/// The files that settings.toml names for a live station.
void check_station_files(DoctorReport& report, const StationFiles& files, const ModelReader& reader);

/// Opens, whole, write-ahead log, writable. A record that is not there yet is no fault if it can be made.
void check_record(DoctorReport& report, const std::filesystem::path& file);

/// That the port can be listened on; 0 always can.
void check_port(DoctorReport& report, const std::string& subject, const std::string& host, int port,
                const std::string& key);

/// Free space where `folder` lies.
void check_disk(DoctorReport& report, const std::filesystem::path& folder);

/// Room for the frame rings.
void check_shared_memory(DoctorReport& report);

/// The built page of the screen.
void check_web(DoctorReport& report, const std::filesystem::path& web_root);

/// The PLC's settings; in server mode also its port.
void check_plc(DoctorReport& report, const PlcParams& params);

}  // namespace deixis
