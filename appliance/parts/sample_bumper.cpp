// The sample bumpers as solid modelling: body minus hollow, both swept along the same planform (Open
// CASCADE).
#include "appliance/parts/sample_bumper.h"

#include <APIHeaderSection_MakeHeader.hxx>
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepOffsetAPI_MakePipe.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <GC_MakeArcOfCircle.hxx>
#include <IFSelect_ReturnStatus.hxx>
#include <Interface_Static.hxx>
#include <STEPControl_Writer.hxx>
#include <Standard_Failure.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopTools_ListOfShape.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>
#include <TopoDS_Wire.hxx>
#include <cmath>
#include <gp_Ax2.hxx>
#include <gp_Pnt2d.hxx>
#include <gp_Vec2d.hxx>
#include <numbers>
#include <vector>

#include "appliance/parts/quiet_occt.h"

namespace deixis {
namespace {

// All lengths in this file are millimetres, all angles radians.
constexpr double degree = std::numbers::pi / 180;
constexpr double wall = 3;

/// Seen from above: a wide arc, a tight corner arc at each end, a short straight end; symmetric about x = 0.
/// Places on it are named by the turn of the outward normal from -y.
struct Planform {
    double width, front_radius, corner_radius, end_turn, end_length;

    double front_turn() const {
        return std::asin((width / 2 - corner_radius * std::sin(end_turn) - end_length * std::cos(end_turn)) /
                         (front_radius - corner_radius));
    }
    gp_Vec outward(double turn) const { return {std::sin(turn), -std::cos(turn), 0}; }
    gp_Pnt at(double turn) const {
        const double corner = front_turn(), side = turn < 0 ? -1 : 1;
        const bool in_front = std::abs(turn) <= corner;
        const double radius = in_front ? front_radius : corner_radius;
        const double offset = in_front ? 0 : front_radius - corner_radius;
        return gp_Pnt(0, front_radius, 0)
            .Translated(outward(side * corner) * offset + outward(turn) * radius);
    }
    /// From the left (-x) end to the right one, each end `longer` than drawn.
    TopoDS_Wire spine(double longer) const {
        const double corner = front_turn();
        const auto end = [&](double side) {
            const gp_Vec backwards(side * std::cos(end_turn), std::sin(end_turn), 0);
            return at(side * end_turn).Translated(backwards * (end_length + longer));
        };
        const auto arc = [&](double from, double to) {
            return BRepBuilderAPI_MakeEdge(GC_MakeArcOfCircle(at(from), at((from + to) / 2), at(to)).Value())
                .Edge();
        };
        BRepBuilderAPI_MakeWire wire;
        wire.Add(BRepBuilderAPI_MakeEdge(end(-1), at(-end_turn)).Edge());
        wire.Add(arc(-end_turn, -corner));
        wire.Add(arc(-corner, corner));
        wire.Add(arc(corner, end_turn));
        wire.Add(BRepBuilderAPI_MakeEdge(at(end_turn), end(1)).Edge());
        return wire.Wire();
    }
};

/// A bend of the profile: `out` along the outward normal, `up` along z, rounded with `radius`.
struct Bend {
    double out, up, radius;
};

gp_Pnt2d corner_of(const Bend& b) {
    return {b.out, b.up};
}

/// The bends moved to the inside by `distance`, radii changed so that the wall keeps its thickness in the
/// rounds.
std::vector<Bend> moved_inwards(const std::vector<Bend>& profile, double distance) {
    std::vector<Bend> moved;
    for (size_t i = 0; i < profile.size(); ++i) {
        // The profile runs from the lower to the upper edge with the outside on its right.
        const auto inward = [&](size_t a, size_t b) {
            const gp_Vec2d along(corner_of(profile[a]), corner_of(profile[b]));
            return gp_Vec2d(-along.Y(), along.X()).Normalized();
        };
        const gp_Vec2d before = i > 0 ? inward(i - 1, i) : inward(i, i + 1);
        const gp_Vec2d after = i + 1 < profile.size() ? inward(i, i + 1) : before;
        const gp_Vec2d middle = (before + after).Normalized();
        const double length = distance / middle.Dot(before);
        const bool convex = before.Crossed(after) > 0;
        moved.push_back({profile[i].out + middle.X() * length, profile[i].up + middle.Y() * length,
                         profile[i].radius > 0 ? profile[i].radius + (convex ? -distance : distance) : 0});
    }
    return moved;
}

/// The face enclosed by the rounded bends and a straight closing `depth` behind the planform.
TopoDS_Face filled_profile(const std::vector<Bend>& profile, double depth, const gp_Pnt& origin,
                           const gp_Vec& out) {
    const auto place = [&](const gp_Pnt2d& p) {
        return origin.Translated(out * p.X() + gp_Vec(0, 0, 1) * p.Y());
    };
    BRepBuilderAPI_MakeWire wire;
    gp_Pnt2d last(-depth, profile.front().up);
    const auto line_to = [&](const gp_Pnt2d& p) {
        if (p.Distance(last) > 1e-6) wire.Add(BRepBuilderAPI_MakeEdge(place(last), place(p)).Edge());
        last = p;
    };
    line_to(corner_of(profile.front()));
    for (size_t i = 1; i + 1 < profile.size(); ++i) {
        const gp_Pnt2d bend = corner_of(profile[i]);
        const gp_Vec2d in = gp_Vec2d(bend, corner_of(profile[i - 1])).Normalized();
        const gp_Vec2d on = gp_Vec2d(bend, corner_of(profile[i + 1])).Normalized();
        const double half = std::abs(in.Angle(on)) / 2;
        const double tangent = profile[i].radius / std::tan(half);
        const double to_middle = profile[i].radius / std::sin(half) - profile[i].radius;
        const gp_Pnt2d start = bend.Translated(in * tangent), stop = bend.Translated(on * tangent);
        const gp_Pnt2d middle = bend.Translated((in + on).Normalized() * to_middle);
        line_to(start);
        wire.Add(BRepBuilderAPI_MakeEdge(GC_MakeArcOfCircle(place(start), place(middle), place(stop)).Value())
                     .Edge());
        last = stop;
    }
    line_to(corner_of(profile.back()));
    line_to({-depth, profile.back().up});
    line_to({-depth, profile.front().up});
    return BRepBuilderAPI_MakeFace(wire.Wire(), true).Face();
}

TopoDS_Shape swept(const Planform& planform, const std::vector<Bend>& profile, double depth, double longer) {
    const double end = -planform.end_turn;
    const gp_Vec backwards(-std::cos(end), -std::sin(end), 0);
    const gp_Pnt origin = planform.at(end).Translated(backwards * (planform.end_length + longer));
    const TopoDS_Face face = filled_profile(profile, depth, origin, planform.outward(end));
    return BRepOffsetAPI_MakePipe(planform.spine(longer), face).Shape();
}

/// A pocket or hole square to the skin at a turn of the planform: `width` x `height` about height `up`,
/// between `near` and `far` along the outward normal; round when `height` is 0. `grown` widens it for the
/// hollow behind it.
struct Pocket {
    double turn, up, width, height, back;

    TopoDS_Shape solid(const Planform& planform, double front, double grown) const {
        const gp_Vec out = planform.outward(turn);
        const gp_Pnt deep = planform.at(turn).Translated(out * (back - grown) + gp_Vec(0, 0, up));
        const double length = front - back + grown;
        const gp_Dir along(-std::cos(turn), -std::sin(turn), 0);
        if (height <= 0)
            return BRepPrimAPI_MakeCylinder(gp_Ax2(deep, gp_Dir(out)), width / 2 + grown, length).Shape();
        const double w = width + 2 * grown, h = height + 2 * grown;
        const gp_Dir upwards = gp_Dir(out).Crossed(along);
        const gp_Pnt corner = deep.Translated(gp_Vec(along) * (-w / 2) + gp_Vec(upwards) * (-h / 2));
        return BRepPrimAPI_MakeBox(gp_Ax2(corner, gp_Dir(out), along), w, h, length).Shape();
    }
};

struct BumperDrawing {
    Planform planform;
    std::vector<Bend> profile;               ///< lower to upper edge
    double depth;                            ///< of the flanges behind the planform
    std::vector<Pocket> pockets;             ///< recesses with walls
    std::vector<Pocket> holes;               ///< through the skin
    double arch_back, arch_up, arch_radius;  ///< wheel arch: a cylinder along x cut out of both ends
};

BumperDrawing front_bumper() {
    BumperDrawing d;
    d.planform = {1700, 2500, 230, 80 * degree, 130};
    d.profile = {{-170, 20, 0}, {-14, 0, 14},  {4, 62, 22},    {-12, 118, 26},
                 {26, 205, 30}, {34, 330, 34}, {-22, 418, 30}, {-170, 462, 0}};
    d.depth = 170;
    d.pockets = {
        {0.02, 160, 530, 112, -24}, {-32 * degree, 92, 104, 0, -58}, {27 * degree, 96, 150, 74, -50}};
    for (const double turn : {-20.0, -6.5, 6.5, 20.0}) d.holes.push_back({turn * degree, 262, 24, 0, -40});
    d.holes.push_back({9.5 * degree, 365, 62, 62, -60});
    d.arch_back = 640, d.arch_up = -30, d.arch_radius = 335;
    return d;
}

BumperDrawing rear_bumper() {
    BumperDrawing d;
    d.planform = {1550, 4200, 215, 72 * degree, 190};
    d.profile = {{-150, -22, 0}, {-30, 0, 10},  {-8, 150, 20},  {-46, 182, 16}, {-40, 236, 16},
                 {22, 262, 18},  {16, 352, 24}, {-96, 372, 30}, {-150, 358, 0}};
    d.depth = 150;
    d.pockets = {{-4.2 * degree, 74, 420, 100, -52}, {6.5 * degree, 306, 260, 44, -18}};
    for (const double turn : {-6.0, -2.0, 2.0, 6.0}) d.holes.push_back({turn * degree, 128, 22, 0, -50});
    d.holes.push_back({6.3 * degree, 30, 240, 90, -120});
    d.holes.push_back({-40 * degree, 60, 110, 0, -60});
    d.arch_back = 620, d.arch_up = 20, d.arch_radius = 330;
    return d;
}

/// Lengthens the flange that runs from `next` to `edge`, so that the hollow is open at the back.
void extend(Bend& edge, const Bend& next) {
    const gp_Vec2d flange = gp_Vec2d(corner_of(next), corner_of(edge)).Normalized() * 12;
    edge.out += flange.X();
    edge.up += flange.Y();
}

TopoDS_Shape cut(const TopoDS_Shape& body, const std::vector<TopoDS_Shape>& tools) {
    TopTools_ListOfShape bodies, cutters;
    bodies.Append(body);
    for (const TopoDS_Shape& t : tools) cutters.Append(t);
    BRepAlgoAPI_Cut operation;
    operation.SetArguments(bodies);
    operation.SetTools(cutters);
    operation.Build();
    if (!operation.IsDone()) throw Standard_Failure("cut failed");
    return operation.Shape();
}

TopoDS_Shape modelled(const BumperDrawing& d) {
    constexpr double in_front = 200;
    std::vector<TopoDS_Shape> recesses, bulges, openings;
    for (const Pocket& p : d.pockets) {
        recesses.push_back(p.solid(d.planform, in_front, 0));
        bulges.push_back(p.solid(d.planform, in_front, wall));
    }
    for (const Pocket& p : d.holes) openings.push_back(p.solid(d.planform, in_front, 0));
    const double reach = 2 * d.planform.width;
    openings.push_back(
        BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(-reach / 2, d.arch_back, d.arch_up), gp_Dir(1, 0, 0)),
                                 d.arch_radius, reach)
            .Shape());
    std::vector<Bend> inside = moved_inwards(d.profile, wall);
    extend(inside.front(), inside[1]);
    extend(inside.back(), inside[inside.size() - 2]);
    const TopoDS_Shape body = cut(swept(d.planform, d.profile, d.depth, 0), recesses);
    const TopoDS_Shape hollow = cut(swept(d.planform, inside, d.depth + 20, 20), bulges);
    openings.push_back(hollow);
    return cut(body, openings);
}

}  // namespace

Result<void> write_sample_bumper(SampleBumper variant, const std::filesystem::path& step_file) {
    const QuietOcct quiet;
    try {
        const TopoDS_Shape shape = modelled(variant == SampleBumper::a ? front_bumper() : rear_bumper());
        STEPControl_Writer writer;
        Interface_Static::SetCVal("write.step.unit", "MM");
        Interface_Static::SetCVal("write.step.product.name",
                                  variant == SampleBumper::a ? "bumper-a" : "bumper-b");
        const bool transferred = writer.Transfer(shape, STEPControl_AsIs) == IFSelect_RetDone;
        // The same bumper makes the same bytes, so the stamp of creation is not the wall clock's.
        APIHeaderSection_MakeHeader header(writer.Model());
        header.SetTimeStamp(new TCollection_HAsciiString("2024-01-01T00:00:00"));
        header.Apply(writer.Model());
        if (!transferred || writer.Write(step_file.c_str()) != IFSelect_RetDone)
            return fail(step_file.string() + ": the STEP file cannot be written there.");
    } catch (const Standard_Failure& failure) {
        return fail(step_file.string() + ": the bumper could not be modelled (" + failure.GetMessageString() +
                    ").");
    }
    return {};
}

}  // namespace deixis
