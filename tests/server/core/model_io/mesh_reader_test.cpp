// SPDX-License-Identifier: Apache-2.0
#include "core/model_io/mesh_reader.hpp"

#include "core/decomposition/surface_bodies.hpp"
#include "core/model_io/file_fault.hpp"
#include "core/model_io/geometry_shapes.hpp"
#include "support/meshes.hpp"
#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <cstring>

namespace handover {
namespace {

using ::testing::HasSubstr;

/// An axis-aligned box as OBJ lines; indices count on from `first`.
std::string objBox(const std::string& name, const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                   int first) {
  std::string text = "o " + name + "\n";
  for (int i = 0; i < 8; ++i) {
    text += "v " + std::to_string(i & 1 ? high.x() : low.x()) + " " +
            std::to_string(i & 2 ? high.y() : low.y()) + " " +
            std::to_string(i & 4 ? high.z() : low.z()) + "\n";
  }
  const int quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                           {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& quad : quads) {
    text += "f";
    for (const int corner : quad) text += " " + std::to_string(first + corner);
    text += "\n";
  }
  return text;
}

struct Bounds {
  Eigen::Vector3d low, high;
};

const ConvexShape& convex(const Shape& shape) { return std::get<ConvexShape>(shape.geometry); }

Bounds boundsOf(const Shape& shape) {
  Bounds bounds{convex(shape).vertices.at(0), convex(shape).vertices.at(0)};
  for (const Eigen::Vector3d& v : convex(shape).vertices) {
    bounds.low = bounds.low.cwiseMin(v);
    bounds.high = bounds.high.cwiseMax(v);
  }
  return bounds;
}

double volumeOf(const Shape& shape) {
  double volume = 0;
  for (const auto& t : convex(shape).triangles) {
    const auto corner = [&](int i) {
      return convex(shape).vertices.at(static_cast<std::size_t>(t[static_cast<std::size_t>(i)]));
    };
    volume += corner(0).dot(corner(1).cross(corner(2))) / 6.0;
  }
  return volume;
}

std::string asciiStl(const std::vector<std::array<Eigen::Vector3d, 3>>& triangles) {
  std::string text = "solid part\n";
  for (const auto& t : triangles) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const auto& v : t) {
      text += "vertex " + std::to_string(v.x()) + " " + std::to_string(v.y()) + " " +
              std::to_string(v.z()) + "\n";
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid part\n";
}

std::vector<std::array<Eigen::Vector3d, 3>> tetrahedron() {
  const Eigen::Vector3d o(0, 0, 0), x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  return {{o, y, x}, {o, x, z}, {x, y, z}, {o, z, y}};
}

std::string binaryStl(const std::vector<std::array<Eigen::Vector3d, 3>>& triangles) {
  std::string text(80, ' ');
  const auto put = [&text](const void* data, std::size_t size) {
    text.append(static_cast<const char*>(data), size);
  };
  const auto count = static_cast<std::uint32_t>(triangles.size());
  put(&count, 4);
  for (const auto& t : triangles) {
    const float normal[3] = {0, 0, 0};
    put(normal, 12);
    for (const auto& v : t) {
      const Eigen::Vector3f f = v.cast<float>();
      put(f.data(), 12);
    }
    text.append(2, '\0');
  }
  return text;
}

/// A unit-edge tetrahedron written in `meter` units, its node moved by (1, 2, 3) and turned 90 deg
/// about z, below a parent node scaled by 2.
std::string dae(const std::string& meter, const std::string& up_axis) {
  return R"(<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter=")" +
         meter + R"(" name="u"/><up_axis>)" + up_axis + R"(</up_axis></asset>
<library_geometries><geometry id="g" name="g"><mesh>
<source id="p"><float_array id="pa" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array>
<technique_common><accessor source="#pa" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>0 2 1 0 1 3 1 2 3 0 3 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s" name="s">
<node id="parent"><scale>2 2 2</scale>
 <node id="n1"><translate>1 2 3</translate><rotate>0 0 1 90</rotate><instance_geometry url="#g"/></node>
 <node id="n2"><translate>5 0 0</translate><instance_geometry url="#g"/></node>
</node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
}

class ReadConvexMesh : public ::testing::Test {
 protected:
  std::vector<Shape> read(const std::string& name, const std::string& text,
                          const Eigen::Vector3d& scale = Eigen::Vector3d::Ones()) {
    return readConvexMesh(folder_.write(name, text), scale);
  }

  std::string faultOf(const std::string& name, const std::string& text) {
    try {
      read(name, text);
    } catch (const FileError& error) {
      return error.what();
    }
    return "read";
  }

  test::TemporaryFolder folder_;
};

TEST_F(ReadConvexMesh, KeepsObjObjectsApart) {
  const auto shapes =
      read("two.obj", objBox("a", {0, 0, 0}, {1, 1, 1}, 1) + objBox("b", {2, 0, 0}, {3, 2, 1}, 9));
  ASSERT_EQ(shapes.size(), 2u);
  EXPECT_EQ(convex(shapes[0]).vertices.size(), 8u);
  EXPECT_EQ(convex(shapes[0]).triangles.size(), 12u);
  EXPECT_NEAR(volumeOf(shapes[0]), 1.0, 1e-9);
  EXPECT_NEAR(volumeOf(shapes[1]), 2.0, 1e-9);
  EXPECT_EQ(boundsOf(shapes[1]).low, Eigen::Vector3d(2, 0, 0));
}

TEST_F(ReadConvexMesh, TakesEveryLooseBodyAsItIs) {
  // assimp makes one mesh of objects of one name.
  const auto shapes = read("two.obj", objBox("a", {0, 0, 0}, {0.1, 0.1, 0.1}, 1) +
                                          objBox("a", {0.2, 0, 0}, {0.3, 0.2, 0.1}, 9));
  ASSERT_EQ(shapes.size(), 2u);
  EXPECT_NEAR(volumeOf(shapes[0]) + volumeOf(shapes[1]), 0.003, 1e-9);
}

TEST_F(ReadConvexMesh, BodiesFarApartAreNoLargeBody) {
  std::string text;
  for (int i = 0; i < 4; ++i) {
    text += objBox("legs", Eigen::Vector3d(2 * i, i, 0),
                   Eigen::Vector3d(2 * i, i, 0).array() + 0.05, 1 + 8 * i);
  }
  const auto divide = [](const TriangleMesh&) -> Result<std::vector<TriangleMesh>> {
    return Error{ErrorCode::kInvalidInput, "was asked for"};
  };
  EXPECT_EQ(readConvexMesh(folder_.write("legs.obj", text), {1, 1, 1}, divide).size(), 4u);
}

TEST_F(ReadConvexMesh, ABodyPaintedInTwoColoursIsOneSolid) {
  std::string text = objBox("box", {0, 0, 0}, {0.1, 0.1, 0.03}, 1);
  text.insert(text.find("f "), "usemtl red\n");
  text.insert(text.find("f 3"), "usemtl blue\n");
  const auto shapes = read("two.obj", text);
  ASSERT_EQ(shapes.size(), 1u);
  EXPECT_EQ(convex(shapes[0]).triangles.size(), 12u);
  EXPECT_NEAR(volumeOf(shapes[0]), 0.0003, 1e-9);
}

TEST_F(ReadConvexMesh, ColoursThatAreSolidsThemselvesStayApart) {
  std::string text = objBox("a", {0, 0, 0}, {0.1, 0.1, 0.1}, 1);
  text.insert(text.find("f "), "usemtl red\n");
  std::string blue = objBox("a", {0.1, 0, 0}, {0.2, 0.1, 0.1}, 9);
  blue = blue.substr(blue.find('\n') + 1);
  text += blue.insert(blue.find("f "), "usemtl blue\n");
  const auto shapes = read("two.obj", text);
  ASSERT_EQ(shapes.size(), 2u);
  EXPECT_NEAR(volumeOf(shapes[0]), 0.001, 1e-9);
}

TEST_F(ReadConvexMesh, KeepsTheSurfaceOfWhatItDivides) {
  const auto file =
      folder_.write("cup.stl", test::stlText(test::moved(test::cupMesh(), Pose::Identity(), 1000)));
  const BodyShapes body = readMeshBodies(file, {0.001, -0.001, 0.001});
  ASSERT_EQ(body.divided.size(), 1u);
  const DividedBody& cup = body.divided[0];
  EXPECT_EQ(cup.open_edges, 0);
  EXPECT_EQ(cup.first_shape, 0);
  EXPECT_EQ(cup.shape_count, static_cast<int>(body.shapes.size()));
  EXPECT_EQ(cup.surface.triangles.size(), test::cupMesh().triangles.size());
  // Outward, though it is mirrored.
  EXPECT_NEAR(signedVolume(cup.surface), signedVolume(test::cupMesh()), 1e-9);
}

TEST_F(ReadConvexMesh, ReadsAsciiAndBinaryStl) {
  for (const std::string& text : {asciiStl(tetrahedron()), binaryStl(tetrahedron())}) {
    const auto shapes = read("t.stl", text);
    ASSERT_EQ(shapes.size(), 1u);
    EXPECT_EQ(convex(shapes[0]).vertices.size(), 4u);
    EXPECT_EQ(convex(shapes[0]).triangles.size(), 4u);
    EXPECT_NEAR(volumeOf(shapes[0]), 1.0 / 6, 1e-9);
  }
}

TEST_F(ReadConvexMesh, TurnsAnInsideOutSurfaceOutward) {
  auto triangles = tetrahedron();
  for (auto& t : triangles) std::swap(t[0], t[1]);
  EXPECT_NEAR(volumeOf(read("t.stl", asciiStl(triangles)).at(0)), 1.0 / 6, 1e-9);
}

TEST_F(ReadConvexMesh, ScalesAndMirrors) {
  const auto shapes = read("t.stl", asciiStl(tetrahedron()), {2, -3, 0.5});
  EXPECT_NEAR(volumeOf(shapes.at(0)), 0.5, 1e-9);
  EXPECT_EQ(boundsOf(shapes[0]).low, Eigen::Vector3d(0, -3, 0));
  EXPECT_EQ(boundsOf(shapes[0]).high, Eigen::Vector3d(2, 0, 0.5));
}

TEST_F(ReadConvexMesh, HonoursColladaUnitsAndNodeTransforms) {
  for (const char* up_axis : {"Z_UP", "Y_UP"}) {
    for (const double meter : {1.0, 0.001, 0.0254}) {
      const auto shapes = read("t.dae", dae(std::to_string(meter), up_axis));
      ASSERT_EQ(shapes.size(), 2u) << up_axis;
      const double size = std::stod(std::to_string(meter));
      const Eigen::Vector3d low = size * Eigen::Vector3d(0, 4, 6);
      EXPECT_TRUE((boundsOf(shapes[0]).low - low).norm() < 1e-6 * size);
      EXPECT_TRUE(boundsOf(shapes[0]).high.isApprox(size * Eigen::Vector3d(2, 6, 8), 1e-6));
      EXPECT_TRUE(boundsOf(shapes[1]).low.isApprox(size * Eigen::Vector3d(10, 0, 0), 1e-6));
      EXPECT_TRUE(boundsOf(shapes[1]).high.isApprox(size * Eigen::Vector3d(12, 2, 2), 1e-6));
    }
  }
}

TEST_F(ReadConvexMesh, DividesOnlyWhatIsNotConvex) {
  // A square-based pyramid with its apex pushed into the body of a box below: one dent.
  std::string text = "o dent\n";
  text += "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nv 0.5 0.5 0.9\n";
  text +=
      "f 4 3 2 1\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nf 5 6 9\nf 6 7 9\nf 7 8 9\nf 8 5 9\n";
  text += objBox("box", {2, 0, 0}, {3, 1, 1}, 10);
  std::vector<TriangleMesh> divided;
  const ConvexDecomposer divide = [&divided](const TriangleMesh& mesh) {
    divided.push_back(mesh);
    return std::vector{test::boxMesh({0, 0, 0}, {1, 1, 1}), test::boxMesh({0, 0, 0}, {1, 1, 0.5})};
  };
  const auto shapes = readConvexMesh(folder_.write("dent.obj", text), {2, 2, 2}, divide);
  ASSERT_EQ(divided.size(), 1u);
  EXPECT_EQ(divided[0].vertices.size(), 9u);
  EXPECT_EQ(divided[0].triangles.size(), 14u);
  EXPECT_EQ(divided[0].vertices.at(0), Eigen::Vector3d(0, 2, 0));  // scaled before
  ASSERT_EQ(shapes.size(), 3u);
  EXPECT_EQ(boundsOf(shapes[2]).low, Eigen::Vector3d(4, 0, 0));
}

TEST_F(ReadConvexMesh, NamesEveryPartThatCannotBeDivided) {
  const std::string text =
      "o one\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
      "o two\nv 0 0 1\nv 1 0 1\nv 0 1 1\nf 4 5 6\n";
  const auto divide = [](const TriangleMesh&) -> Result<std::vector<TriangleMesh>> {
    return Error{ErrorCode::kInvalidInput, "is too large"};
  };
  try {
    readConvexMesh(folder_.write("open.obj", text), {1, 1, 1}, divide);
    FAIL() << "was read";
  } catch (const FileError& error) {
    ASSERT_EQ(error.faults().size(), 2u);
    EXPECT_THAT(error.faults()[0].text(), HasSubstr("open.obj: part 'one' is too large"));
    EXPECT_THAT(error.faults()[1].text(), HasSubstr("open.obj: part 'two' is too large"));
  }
}

TEST_F(ReadConvexMesh, GivesFlatBodiesAThickness) {
  const auto shapes = read("flat.obj", "o f\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1\n");
  ASSERT_EQ(shapes.size(), 1u);
  EXPECT_NEAR(volumeOf(shapes[0]), 0.5 * 0.0002, 1e-9);
}

TEST_F(ReadConvexMesh, ForgivesATenthOfAMillimetre) {
  std::string text = "o dent\n";
  text +=
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nv 0.5 0.5 0.99999\n";
  text +=
      "f 4 3 2 1\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nf 5 6 9\nf 6 7 9\nf 7 8 9\nf 8 5 9\n";
  EXPECT_EQ(read("ok.obj", text).size(), 1u);
}

TEST_F(ReadConvexMesh, RefusesOtherFormatsAndDamage) {
  EXPECT_THAT(faultOf("a.ply", "ply\n"), HasSubstr("is not STL, OBJ or DAE"));
  EXPECT_THAT(faultOf("a.dae", "<COLLADA"), HasSubstr("a.dae:1: is not well-formed XML"));
  EXPECT_THAT(faultOf("a.stl", "hello"), HasSubstr("a.stl: is no STL"));
  EXPECT_NE(faultOf("a.obj", "o x\nv 0 0\nf 1 2 9\n"), "read");
  EXPECT_NE(faultOf("b.obj", ""), "read");
  EXPECT_NE(faultOf("c.obj", "o x\nv 0 0 0\nv 1 0 0\nv nan 1 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\n"),
            "read");
  std::string cut = binaryStl(tetrahedron());
  cut.resize(cut.size() - 60);
  EXPECT_NE(faultOf("cut.stl", cut), "read");
  EXPECT_THROW(readConvexMesh(folder_.path() / "none.stl", Eigen::Vector3d::Ones()), FileError);
}

constexpr const char* kObj =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::runtime_error("no " + from);
  return text.replace(at, from.size(), to);
}

TEST_F(ReadConvexMesh, NamesTheLineOfAnObjsFault) {
  const auto fault = [&](const std::string& from, const std::string& to) {
    return faultOf("a.obj", replaced(kObj, from, to));
  };
  EXPECT_EQ(faultOf("a.obj", kObj), "read");
  EXPECT_THAT(fault("v 1 0 0", "v nan 0 0"),
              HasSubstr("a.obj:2: vertex is not a finite number: 'nan'"));
  EXPECT_THAT(fault("v 1 0 0", "v 1e400 0 0"),
              HasSubstr("a.obj:2: vertex is not a finite number: '1e400'"));
  EXPECT_THAT(fault("v 1 0 0", "v 1,5 0 0"),
              HasSubstr("a.obj:2: vertex is not a finite number: '1,5'"));
  EXPECT_THAT(fault("v 1 0 0", "v 1 0"),
              HasSubstr("a.obj:2: a vertex has fewer than three numbers"));
  EXPECT_THAT(fault("f 2 3 4", "f 2 3 5"), HasSubstr("a.obj:7: a face names vertex '5' of 4"));
  EXPECT_THAT(fault("f 2 3 4", "f 2 3 -5"), HasSubstr("a.obj:7: a face names vertex '-5' of 4"));
  EXPECT_THAT(fault("f 2 3 4", "f 2 3 0"), HasSubstr("a.obj:7: a face names vertex '0' of 4"));
  EXPECT_THAT(fault("f 2 3 4", "f 2 3 99999999999999999999"), HasSubstr("a.obj:7: a face names"));
  EXPECT_THAT(faultOf("a.obj", "v 0 0 0\nv 1 0 0\n"), HasSubstr("a.obj: holds no triangles"));
  EXPECT_THAT(faultOf("a.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n"), HasSubstr("holds no triangles"));
  EXPECT_THAT(fault("v 1 0 0", "v 2000 0 0"), HasSubstr("beyond 1 km"));
  EXPECT_EQ(fault("v 1 0 0", "v 1 0 0 # a corner"), "read");
}

TEST_F(ReadConvexMesh, NamesTheLineOfAColladaFault) {
  const std::string good = dae("1", "Z_UP");
  const auto fault = [&](const std::string& from, const std::string& to) {
    return faultOf("a.dae", replaced(good, from, to));
  };
  EXPECT_EQ(faultOf("a.dae", good), "read");
  EXPECT_THAT(fault("meter=\"1\"", "meter=\"0\""),
              HasSubstr("a.dae:3: <unit>: meter is not a number above 0: '0'"));
  EXPECT_THAT(fault("meter=\"1\"", "meter=\"0,01\""), HasSubstr("a.dae:3: <unit>: meter"));
  EXPECT_THAT(fault("0 0 0 1 0 0", "0 0 inf 1 0 0"),
              HasSubstr("a.dae:5: <float_array> is not a finite number: 'inf'"));
  EXPECT_THAT(fault("5 0 0", "5 nan 0"), HasSubstr("<translate> is not a finite number: 'nan'"));
  EXPECT_THAT(fault("count=\"12\"", "count=\"4000000000\""),
              HasSubstr("a.dae:5: <float_array>: count does not fit the file: '4000000000'"));
  EXPECT_THAT(fault("offset=\"0\"", "offset=\"-1\""), HasSubstr("<input>: offset does not fit"));
  EXPECT_THAT(fault("0 3 2</p>", "0 3 9</p>"), HasSubstr("cannot be read as a mesh"));
  EXPECT_THAT(fault("0 3 2</p>", "0 { 2</p>"),
              HasSubstr("a.dae:8: <p> is not of whole numbers: '{'"));
  EXPECT_THAT(fault("id=\"pa\" count=\"12\"", "id=\"pa\""),
              HasSubstr("a.dae:5: <float_array> has no count"));
  EXPECT_THAT(fault("COLLADA xmlns", "HTML xmlns"), HasSubstr("is not well-formed XML"));
  EXPECT_THAT(faultOf("a.dae", "<html/>"), HasSubstr("a.dae:1: has no <COLLADA> as its root"));
}

TEST_F(ReadConvexMesh, RefusesColladaNodesWithoutEnd) {
  const std::string good = dae("1", "Z_UP");
  const auto with_nodes = [&](const std::string& nodes) {
    return replaced(replaced(good, "<library_visual",
                             "<library_nodes>" + nodes + "</library_nodes><library_visual"),
                    "<node id=\"n2\">", "<node id=\"n2\"><instance_node url=\"#x0\"/>");
  };
  EXPECT_THAT(faultOf("a.dae", with_nodes("<node id='x0'><instance_node url='#x0'/></node>")),
              HasSubstr("<node> holds an instance of itself"));
  std::string chain, bomb;
  for (int i = 0; i < 1000; ++i) {
    const std::string next = "<instance_node url='#x" + std::to_string(i + 1) + "'/>";
    chain += "<node id='x" + std::to_string(i) + "'>" + next + "</node>";
    if (i < 8) {
      bomb += "<node id='x" + std::to_string(i) + "'>";
      for (int k = 0; k < 10; ++k) bomb += next;
      bomb += "</node>";
    }
  }
  EXPECT_THAT(faultOf("a.dae", with_nodes(chain)), HasSubstr("<node> is nested too deep"));
  EXPECT_THAT(faultOf("a.dae", with_nodes(bomb)),
              HasSubstr("has more than 4096 nodes and instances"));
  std::string deep = good;
  for (int i = 0; i < 100'000; ++i) deep += "<node>";
  EXPECT_THAT(faultOf("a.dae", replaced(good, "<node id=\"parent\">", deep)),
              HasSubstr("is not well-formed XML"));
}

TEST_F(ReadConvexMesh, NamesTheFaultsOfAnStl) {
  std::string lie = binaryStl(tetrahedron());
  for (const char count : {0, 2, 5, 127}) {
    lie[80] = count;
    EXPECT_THAT(faultOf("a.stl", lie), HasSubstr("a count of triangles that fits the size, 4"));
  }
  auto triangles = tetrahedron();
  triangles[2][1].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(faultOf("a.stl", binaryStl(triangles)),
              HasSubstr("triangle 2 has a vertex that is not finite"));
  EXPECT_THAT(faultOf("a.stl", asciiStl(triangles)),
              HasSubstr("a.stl:19: vertex is not a finite number"));
  EXPECT_THAT(faultOf("a.stl", replaced(asciiStl(tetrahedron()), "1.0", "1,0")),
              HasSubstr("a.stl:5: vertex is not a finite number: '1,000000'"));
  const Eigen::Vector3d o(0, 0, 0);
  EXPECT_THAT(faultOf("a.stl", binaryStl({{o, o, o}})), HasSubstr("holds no triangles"));
}

TEST_F(ReadConvexMesh, OfAnySizeIsRefusedSoon) {
  for (const char* name : {"a.stl", "a.obj", "a.dae"}) {
    const auto sparse = folder_.write(name, "");
    std::filesystem::resize_file(sparse, std::uintmax_t{2} << 30);
    try {
      readConvexMesh(sparse, Eigen::Vector3d::Ones());
      FAIL();
    } catch (const FileError& error) {
      EXPECT_THAT(error.what(), HasSubstr("is larger than 64 MiB"));
    }
  }
  std::string faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\n", polygon = faces + "f", objects = kObj;
  for (int i = 0; i < 600'000; ++i) faces += "f 1 2 3\n";
  for (int i = 0; i < 1000; ++i) polygon += " 1 2 3";
  for (int i = 0; i < 5000; ++i) objects += "o o" + std::to_string(i) + "\nf 1 3 2\n";
  EXPECT_THAT(faultOf("a.obj", faces), HasSubstr("a.obj:500004: has more than 500000 triangles"));
  EXPECT_THAT(faultOf("a.obj", polygon),
              HasSubstr("a.obj:4: a face has 3000 corners, more than 256"));
  EXPECT_THAT(faultOf("a.obj", objects),
              HasSubstr("has more than 4096 objects, groups and materials"));
  EXPECT_THAT(faultOf("a.stl", binaryStl(std::vector<std::array<Eigen::Vector3d, 3>>(
                                   500'001, tetrahedron()[0]))),
              HasSubstr("has more than 500000 triangles"));
}

TEST_F(ReadConvexMesh, OpensNoOtherFile) {
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);  // to open it would wait for ever
  EXPECT_EQ(read("a.obj", std::string("mtllib pipe\n") + kObj).size(), 1u);
}

TEST_F(ReadConvexMesh, MustBeAPlainFile) {
  std::filesystem::create_directory(folder_ / "folder.obj");
  ASSERT_EQ(::mkfifo((folder_ / "pipe.obj").c_str(), 0600), 0);
  std::filesystem::create_symlink("/dev/zero", folder_ / "zero.obj");
  std::filesystem::create_symlink("loop.obj", folder_ / "loop.obj");
  folder_.write("real.obj", kObj);
  std::filesystem::create_symlink("real.obj", folder_ / "link.obj");
  const auto fault = [&](const char* name) -> std::string {
    try {
      readConvexMesh(folder_ / name, Eigen::Vector3d::Ones());
    } catch (const FileError& error) {
      return error.faults().at(0).message;
    }
    return "read";
  };
  EXPECT_EQ(fault("folder.obj"), "is a folder, not a file");
  EXPECT_EQ(fault("pipe.obj"), "is a pipe, not a plain file");
  EXPECT_EQ(fault("zero.obj"), "is a device, not a plain file");
  EXPECT_THAT(fault("loop.obj"), HasSubstr("cannot be read: "));
  EXPECT_EQ(fault("link.obj"), "read");
  EXPECT_EQ(fault("none.obj"), "no such file");
}

TEST_F(ReadConvexMesh, FitsIntoCompoundGeometry) {
  folder_.write("t.stl", asciiStl(tetrahedron()));
  CompoundGeometry compound;
  GeometryPart box;
  box.X_OS.xyz = {0, 0, 2};
  box.geometry = BoxGeometry{{1, 2, 3}};
  GeometryPart mesh;
  mesh.X_OS.xyz = {1, 0, 0};
  mesh.geometry = MeshGeometry{"t.stl", {1, 1, 1}};
  compound.parts = {box, mesh};
  const auto shapes = bodyShapesOf(compound, folder_.path()).shapes;
  ASSERT_EQ(shapes.size(), 2u);
  EXPECT_EQ(std::get<BoxShape>(shapes[0].geometry).size, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(shapes[0].X_BS.translation(), Eigen::Vector3d(0, 0, 2));
  EXPECT_EQ(shapes[1].X_BS.translation(), Eigen::Vector3d(1, 0, 0));
}

TEST_F(ReadConvexMesh, SurfacesStandWhereTheirPartsDo) {
  folder_.write("angle.stl", test::stlText(test::angleMesh()));
  CompoundGeometry compound;
  for (int i = 0; i < 2; ++i) {
    GeometryPart mesh;
    mesh.X_OS.xyz = {1.0 + i, 0, 0};
    mesh.geometry = MeshGeometry{"angle.stl", {1, 1, 1}};
    compound.parts.push_back(mesh);
  }
  const BodyShapes body = bodyShapesOf(compound, folder_.path());
  ASSERT_EQ(body.divided.size(), 2u);
  EXPECT_EQ(body.divided[1].first_shape, body.divided[0].shape_count);
  EXPECT_EQ(body.divided[0].hash, body.divided[1].hash);
  double least = 9;
  for (const Eigen::Vector3d& v : body.divided[1].surface.vertices) least = std::min(least, v.x());
  EXPECT_NEAR(least, 2, 1e-7);
}

}  // namespace
}  // namespace handover
