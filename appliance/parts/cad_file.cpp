// Open CASCADE's readers, their faces meshed and gathered.
#include "appliance/parts/cad_file.h"

#include <BRepBndLib.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <IFSelect_WorkLibrary.hxx>
#include <IGESControl_Reader.hxx>
#include <Interface_InterfaceModel.hxx>
#include <Interface_Protocol.hxx>
#include <Interface_Static.hxx>
#include <Poly_Triangulation.hxx>
#include <STEPControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopExp_Explorer.hxx>
#include <TopLoc_Location.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <XSControl_WorkSession.hxx>
#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <optional>
#include <string>
#include <string_view>

#include "appliance/parts/quiet_occt.h"

namespace deixis {
namespace {

/// Beginnings of Open CASCADE's names of entities that a surface is made of.
constexpr std::array<std::string_view, 5> shape_kinds = {"StepGeom_", "StepShape_", "StepRepr_", "StepBasic_",
                                                         "IGES"};

void append_face(SurfaceMesh& mesh, const TopoDS_Face& face) {
    TopLoc_Location location;
    const Handle(Poly_Triangulation) facets = BRep_Tool::Triangulation(face, location);
    if (facets.IsNull()) return;
    const auto first = static_cast<uint32_t>(mesh.vertices.size());
    for (int i = 1; i <= facets->NbNodes(); ++i) {
        const gp_Pnt p = facets->Node(i).Transformed(location.Transformation());
        mesh.vertices.emplace_back(static_cast<float>(p.X() * 1e-3), static_cast<float>(p.Y() * 1e-3),
                                   static_cast<float>(p.Z() * 1e-3));
    }
    const bool turned = face.Orientation() == TopAbs_REVERSED;
    for (int i = 1; i <= facets->NbTriangles(); ++i) {
        int a = 0, b = 0, c = 0;
        facets->Triangle(i).Get(a, b, c);
        if (turned) std::swap(b, c);
        mesh.triangles.push_back({first + a - 1, first + b - 1, first + c - 1});
    }
}

Result<SurfaceMesh> meshed(const TopoDS_Shape& shape, const std::string& name) {
    Bnd_Box box;
    if (!shape.IsNull()) BRepBndLib::Add(shape, box, false);
    if (box.IsVoid()) return fail(name + ": the file holds no surface, expected at least one face.");
    const double diagonal = std::sqrt(box.SquareExtent());
    if (!std::isfinite(diagonal) || diagonal <= 0)
        return fail(name + ": the shapes have no finite size, expected a part.");
    const BRepMesh_IncrementalMesh mesher(shape, diagonal * 3e-4, false, 0.3, false);
    SurfaceMesh mesh;
    for (TopExp_Explorer faces(shape, TopAbs_FACE); faces.More(); faces.Next())
        append_face(mesh, TopoDS::Face(faces.Current()));
    if (mesh.triangles.empty())
        return fail(name + ": the file holds no surface, expected at least one face.");
    return mesh;
}

/// The first entity of the surface that is damaged, its label with its kind in brackets. Open CASCADE 7.6
/// reads through null pointers where a point, face or the like did not load whole; what is damaged elsewhere
/// (colours, notes, tolerances) does not matter to the surface.
std::optional<std::string> damaged_shape(const Interface_InterfaceModel& model) {
    for (int i = 1; i <= model.NbEntities(); ++i) {
        if (!model.IsErrorEntity(i)) continue;
        const Handle(Standard_Transient)& entity = model.Value(i);
        const std::string kind = entity.IsNull() ? "" : entity->DynamicType()->Name();
        const bool matters =
            std::any_of(shape_kinds.begin(), shape_kinds.end(),
                        [&](const std::string_view& shapes) { return kind.starts_with(shapes); });
        if (matters) return std::string(model.StringLabel(entity)->ToCString()) + " (" + kind + ")";
    }
    return std::nullopt;
}

/// What the reader's own ReadFile does, with a look at the entities before its checks touch them.
Result<void> load_model(XSControl_Reader& reader, const std::filesystem::path& file, const char* kind) {
    const Handle(XSControl_WorkSession) session = reader.WS();
    Handle(Interface_InterfaceModel) model;
    if (session->WorkLibrary()->ReadFile(file.c_str(), model, session->Protocol()) != 0 || model.IsNull())
        return fail(file.string() + ": this is not a readable " + kind + " file.");
    if (const auto damaged = damaged_shape(*model))
        return fail(file.string() + ": the entity " + *damaged +
                    " is damaged or names one that is not there.");
    session->SetModel(model);
    session->SetLoadedFile(file.c_str());
    session->InitTransferReader(4);
    return {};
}

template <class Reader>
Result<SurfaceMesh> read_with(Reader& reader, const std::filesystem::path& file, const char* kind) {
    if (const auto loaded = load_model(reader, file, kind); !loaded) return tl::unexpected(loaded.error());
    Interface_Static::SetCVal("xstep.cascade.unit", "MM");
    if (reader.NbRootsForTransfer() < 1 || reader.TransferRoots() < 1)
        return fail(file.string() + ": the " + kind + " file holds no shape.");
    return meshed(reader.OneShape(), file.string());
}

}  // namespace

Result<SurfaceMesh> read_cad_file(const std::filesystem::path& file, bool iges) {
    const QuietOcct quiet;
    const std::string kind = iges ? "IGES" : "STEP";
    try {
        if (iges) {
            IGESControl_Reader reader;
            return read_with(reader, file, "IGES");
        }
        STEPControl_Reader reader;
        return read_with(reader, file, "STEP");
    } catch (const Standard_Failure& failure) {
        return fail(file.string() + ": the " + kind + " file cannot be read (" + failure.GetMessageString() +
                    ").");
    } catch (const std::exception& failure) {
        return fail(file.string() + ": the " + kind + " file cannot be read (" + failure.what() + ").");
    }
}

}  // namespace deixis
