#include "edge_mcl/detector/training/training_room.h"

#include <algorithm>
#include <cmath>

namespace edge_mcl {

namespace {

constexpr int kComputer = 4, kScreen = 5;  // labels

/// Adds boxes and their patterns to a room.
class RoomMaker {
 public:
  RoomMaker(TrainingRandom& random, bool plain, TrainingRoom* room)
      : random_(random), plain_(plain), room_(*room) {}

  uint32_t material(Material material, double plain_share) {
    room_.patterns.push_back(randomPattern(random_, material, plain_ ? 1 : plain_share));
    return static_cast<uint32_t>(room_.patterns.size() - 1);
  }
  SurfacePattern& pattern(uint32_t material) { return room_.patterns[material]; }

  void box(const Eigen::Vector3f& low, const Eigen::Vector3f& high, uint32_t material,
           bool inwards = false) {
    const auto first = static_cast<uint32_t>(room_.mesh.vertices.size());
    for (int k = 0; k < 8; ++k)
      room_.mesh.vertices.emplace_back(k & 1 ? high.x() : low.x(), k & 2 ? high.y() : low.y(),
                                       k & 4 ? high.z() : low.z());
    constexpr uint32_t kSides[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                       {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (int side = 0; side < 6; ++side) {
      const auto& s = kSides[side];
      // The floor, the ceiling and the walls of a room have one material each. A piece of furniture
      // has one material.
      const uint32_t m = inwards ? material + static_cast<uint32_t>(std::min(side, 2)) : material;
      face({first + s[0], first + s[1], first + s[2]}, m);
      face({first + s[0], first + s[2], first + s[3]}, m);
    }
  }

  /// Adds a box. low and high are relative to the middle of its foot, before the turn.
  void piece(const Eigen::Vector3f& foot, const Eigen::Vector3f& low, const Eigen::Vector3f& high,
             int quarters, uint32_t material) {
    const auto turn = [&](const Eigen::Vector3f& v) -> Eigen::Vector3f {
      switch (quarters & 3) {
        case 0:
          return v;
        case 1:
          return {-v.y(), v.x(), v.z()};
        case 2:
          return {-v.x(), -v.y(), v.z()};
        default:
          return {v.y(), -v.x(), v.z()};
      }
    };
    const Eigen::Vector3f a = turn(low), b = turn(high);
    box(foot + a.cwiseMin(b), foot + a.cwiseMax(b), material);
  }

 private:
  void face(const std::array<uint32_t, 3>& corners, uint32_t material) {
    room_.mesh.triangles.push_back(corners);
    room_.mesh.triangle_material.push_back(material);
  }
  TrainingRandom& random_;
  bool plain_;
  TrainingRoom& room_;
};

float number(TrainingRandom& random, double low, double high) {
  return static_cast<float>(uniform(random, low, high));
}

/// Adds flat boxes on the walls, like pictures, doors, windows, boards and cupboards. Also adds
/// skirting boards, columns and beams.
void fitWalls(TrainingRandom& random, RoomMaker* maker, const Eigen::Vector3f& size) {
  const int count = choose(random, 9);
  for (int i = 0; i < count; ++i) {
    const int wall = choose(random, 4);
    const float length = wall % 2 ? size.y() : size.x();
    const bool door = chance(random, 0.25);
    const float width = door ? 0.9f : number(random, 0.2, 1.8);
    const float height = door ? 2.05f : number(random, 0.2, 1.4);
    const float from = number(random, 0.05, std::max(0.06f, length - width - 0.05f));
    const float foot = door ? 0 : number(random, 0, std::max(0.05f, size.z() - height - 0.1f));
    const float thick = chance(random, 0.7) ? number(random, 0.01, 0.06) : number(random, 0.1, 0.6);
    const auto onWall = [&](float a, float b, float z0, float z1, float t, uint32_t material) {
      Eigen::Vector3f low, high;
      const float far = (wall < 2 ? 0 : wall % 2 ? size.x() : size.y());
      const float t0 = wall < 2 ? 0 : far - t, t1 = wall < 2 ? t : far;
      if (wall % 2)
        low = {t0, a, z0}, high = {t1, b, z1};
      else
        low = {a, t0, z0}, high = {b, t1, z1};
      maker->box(low, high, material);
    };
    const float top = std::min(foot + height, size.z() - 0.02f);
    onWall(from, from + width, foot, top, thick, maker->material(Material::kFurniture, 0.6));
    if (chance(random, 0.7)) {  // panes, a picture in its frame, cupboard doors
      const uint32_t inner = maker->material(Material::kFurniture, 0.4);
      if (chance(random, 0.4)) maker->pattern(inner).color = Eigen::Vector3f(0.95f, 0.97f, 1);
      const int panes = 1 + choose(random, 3);
      const float frame = number(random, 0.015, 0.06), step = width / static_cast<float>(panes);
      for (int k = 0; k < panes; ++k)
        onWall(from + step * static_cast<float>(k) + frame,
               from + step * static_cast<float>(k + 1) - frame, foot + frame, top - frame,
               thick + 0.008f, inner);
    }
  }
  if (chance(random, 0.5)) {  // skirting board
    const uint32_t board = maker->material(Material::kFurniture, 0.9);
    const float h = number(random, 0.05, 0.15), t = 0.015f;
    maker->box({0, 0, 0}, {size.x(), t, h}, board);
    maker->box({0, size.y() - t, 0}, {size.x(), size.y(), h}, board);
    maker->box({0, 0, 0}, {t, size.y(), h}, board);
    maker->box({size.x() - t, 0, 0}, {size.x(), size.y(), h}, board);
  }
  for (int i = choose(random, 3); i > 0; --i) {  // columns, beams, ducts
    const uint32_t m = maker->material(Material::kFurniture, 0.7);
    const float w = number(random, 0.1, 0.5), x = number(random, 0, size.x() - w),
                y = number(random, 0, size.y() - w);
    if (chance(random, 0.5))
      maker->box({x, y, 0}, {x + w, y + w, size.z()}, m);
    else
      maker->box({0, y, size.z() - w}, {size.x(), y + w, size.z()}, m);
  }
}

/// Adds a table, shelf, cabinet or bed. These are background: the network must not find them.
/// @param foot middle of its foot, room frame, m. @param radius is set to about half of its size.
/// @return height of its top, m.
float makeFurniture(TrainingRandom& random, RoomMaker* maker, const Eigen::Vector3f& foot,
                    float* radius, bool* is_table) {
  const int quarters = choose(random, 4);
  const uint32_t a = maker->material(Material::kFurniture, 0.5),
                 b = maker->material(Material::kFurniture, 0.8);
  const auto add = [&](const Eigen::Vector3f& low, const Eigen::Vector3f& high, uint32_t m) {
    maker->piece(foot, low, high, quarters, m);
  };
  const int kind = choose(random, 5) % 4;  // tables are twice as likely as the others
  *is_table = kind == 0;
  if (kind == 0) {
    const float w = number(random, 0.35, 1.0), d = number(random, 0.28, 0.5),
                h = chance(random, 0.8) ? number(random, 0.68, 0.8) : number(random, 0.35, 1.1),
                leg = number(random, 0.03, 0.09), t = number(random, 0.02, 0.06);
    add({-w, -d, h - t}, {w, d, h}, a);
    if (chance(random, 0.25)) {
      add({-w, -d, 0}, {-w + leg, d, h - t}, b);
      add({w - leg, -d, 0}, {w, d, h - t}, b);
    } else {
      for (int k = 0; k < 4; ++k) {
        const float x = k & 1 ? w - leg : -w, y = k & 2 ? d - leg : -d;
        add({x, y, 0}, {x + leg, y + leg, h - t}, b);
      }
    }
    if (chance(random, 0.4)) add({w - 0.45f, -d, 0.05f}, {w - 0.03f, d, h - t}, a);
    *radius = w;
    return h;
  }
  if (kind == 1) {  // shelf, with things on its boards
    const float w = number(random, 0.3, 0.8), d = number(random, 0.12, 0.25),
                h = number(random, 0.7, 2.2), t = 0.03f;
    const int boards = 2 + choose(random, 5);
    add({-w, d - 0.02f, 0}, {w, d, h}, b);
    add({-w, -d, 0}, {-w + t, d, h}, a);
    add({w - t, -d, 0}, {w, d, h}, a);
    for (int k = 0; k <= boards; ++k) {
      const float z = (h - t) * static_cast<float>(k) / static_cast<float>(boards);
      add({-w, -d, z}, {w, d, z + t}, a);
      float x = -w + t;
      while (k < boards && x < w - 0.1f && chance(random, 0.85)) {
        const float wide = number(random, 0.03, 0.2), high = number(random, 0.08, 0.3);
        if (chance(random, 0.8))
          add({x, -d + 0.04f, z + t},
              {std::min(x + wide, w - t), d,
               z + t + std::min(high, h / static_cast<float>(boards) - 0.05f)},
              maker->material(Material::kFurniture, 0.7));
        x += wide + 0.004f;
      }
    }
    *radius = w;
    return h;
  }
  if (kind == 2) {  // cabinet, drawers, machine, cardboard box
    const float w = number(random, 0.15, 0.9), d = number(random, 0.15, 0.35),
                h = number(random, 0.25, 2.1);
    add({-w, -d, 0}, {w, d, h}, a);
    const int rows = 1 + choose(random, 4), columns = 1 + choose(random, 3);
    if (chance(random, 0.8))
      for (int r = 0; r < rows; ++r)
        for (int c = 0; c < columns; ++c) {
          const float x = -w + 2 * w * static_cast<float>(c) / static_cast<float>(columns),
                      z = h * static_cast<float>(r) / static_cast<float>(rows);
          add({x + 0.01f, -d - 0.015f, z + 0.01f},
              {x + 2 * w / static_cast<float>(columns) - 0.01f, -d,
               z + h / static_cast<float>(rows) - 0.01f},
              b);
        }
    *radius = w;
    return h;
  }
  const float w = number(random, 0.4, 0.95), d = number(random, 0.9, 1.1),
              h = number(random, 0.3, 0.6);
  add({-w, -d, 0.1f}, {w, d, h}, a);  // bed
  add({-w, d, 0}, {w, d + 0.06f, h + number(random, 0.1, 0.7)}, b);
  add({-0.8f * w, d - 0.5f, h}, {0.8f * w, d - 0.1f, h + 0.12f},
      maker->material(Material::kFurniture, 0.6));
  *radius = d;
  return h;
}

/// Places an object with a random scale, mirroring and patterns. @param foot middle of its foot,
/// room frame, m. @param yaw turn about the vertical, rad.
PlacedObject place(TrainingRandom& random, const TrainingObject& object,
                   const Eigen::Vector3f& foot, float yaw, bool plain_room) {
  PlacedObject placed;
  placed.object = &object;
  const float scale = number(random, 0.92, 1.08);
  Eigen::Vector3f stretch(scale, scale, scale);
  if (chance(random, 0.5)) stretch.x() *= -1;  // a mirrored object is like another object
  placed.T_room_object = Eigen::Translation3f(foot) *
                         Eigen::AngleAxisf(yaw, Eigen::Vector3f::UnitZ()) * Eigen::Scaling(stretch);
  const bool own_colors = chance(random, 0.6);
  const double plain_share = plain_room ? 1 : chance(random, 0.75) ? 0.97 : 0.5;
  const Material material = object.label == kComputer || object.label == kScreen ? Material::kDevice
                            : object.label == 0 ? Material::kFurniture
                                                : Material::kFabric;
  const MeshModel& mesh = object.mesh;
  for (const Eigen::Vector3f& own : mesh.material_colors) {
    SurfacePattern pattern = randomPattern(random, material, plain_share);
    // A white or grey material often has a texture that is not read, so its own colour is wrong.
    const bool textured = own.maxCoeff() - own.minCoeff() < 0.02f && own.maxCoeff() > 0.5f;
    if (own_colors && !(textured && chance(random, 0.5)))
      pattern.color = (own * number(random, 0.7, 1.2)).cwiseMax(0.02f).cwiseMin(1.0f);
    placed.patterns.push_back(pattern);
  }
  return placed;
}

}  // namespace

TrainingRoom randomRoom(TrainingRandom& random, const TrainingObjects& objects) {
  TrainingRoom room;
  const bool plain = chance(random, 0.33);
  RoomMaker maker(random, plain, &room);
  room.size = {number(random, 2.6, 9), number(random, 2.6, 8), number(random, 2.3, 3.6)};
  const uint32_t floor = maker.material(Material::kFloor, 0.3);
  const uint32_t ceiling = maker.material(Material::kWall, 0.85);
  maker.material(Material::kWall, 0.75);
  if (chance(random, 0.6)) maker.pattern(ceiling).color.setConstant(number(random, 0.6, 0.98));
  maker.box(Eigen::Vector3f::Zero(), room.size, floor, true);
  fitWalls(random, &maker, room.size);

  struct Taken {
    Eigen::Vector2f at;
    float radius;
  };
  std::vector<Taken> taken;
  const auto findPlace = [&](float radius, Eigen::Vector3f* foot) {
    for (int attempt = 0; attempt < 12; ++attempt) {
      const float margin = std::min(radius, 1.2f);
      if (room.size.x() < 2 * margin || room.size.y() < 2 * margin) return false;
      foot->x() = number(random, margin, room.size.x() - margin);
      foot->y() = number(random, margin, room.size.y() - margin);
      foot->z() = 0;
      const Eigen::Vector2f at = foot->head<2>();
      if (std::none_of(taken.begin(), taken.end(), [&](const Taken& t) {
            return (t.at - at).norm() < 0.85f * (t.radius + radius);
          })) {
        taken.push_back({at, radius});
        return true;
      }
    }
    return false;
  };
  const auto pick = [&](int label) -> const TrainingObject& {
    const auto& all = objects.ofClass(label);
    return all[static_cast<size_t>(choose(random, static_cast<int>(all.size())))];
  };
  constexpr int kOften[] = {1, 1, 2, 3, 3, 4, 5};  // labels
  const bool empty = chance(random, 0.1);
  Eigen::Vector3f foot;
  for (int i = choose(random, 6); i > 0; --i) {
    if (!findPlace(number(random, 0.5, 1.1), &foot)) continue;
    float radius = 0;
    bool is_table = false;
    const float top = makeFurniture(random, &maker, foot, &radius, &is_table);
    foot.z() = top;
    if (is_table)
      for (int k = choose(random, 3); k > 0; --k) {
        const bool movable = !empty && chance(random, 0.6);
        const TrainingObject& object =
            pick(movable ? chance(random, 0.75) ? kScreen : kComputer : 0);
        if (object.size.maxCoeff() > 1.3f) continue;
        Eigen::Vector3f at = foot;
        at.x() += number(random, -0.3, 0.3);
        at.y() += number(random, -0.2, 0.2);
        room.objects.push_back(place(random, object, at, number(random, 0, 2 * M_PI), plain));
      }
  }
  const int furniture = choose(random, 5), movable = empty ? 0 : 2 + choose(random, 6);
  for (int i = 0; i < furniture + movable; ++i) {
    const TrainingObject& object = pick(i < furniture ? 0 : kOften[choose(random, 7)]);
    if (!findPlace(0.5f * object.size.head<2>().norm(), &foot)) continue;
    foot.z() = std::min(object.elevation, room.size.z() - object.size.z());
    float yaw = number(random, 0, 2 * M_PI);
    if (object.label == kScreen && chance(random, 0.7)) {  // on a wall, facing the room
      const int wall = choose(random, 4);
      constexpr float kGap = 0.08f;
      yaw = static_cast<float>(wall) * static_cast<float>(M_PI) / 2;
      if (wall == 0) foot.y() = room.size.y() - kGap - 0.5f * object.size.y();
      if (wall == 1) foot.x() = kGap + 0.5f * object.size.y();
      if (wall == 2) foot.y() = kGap + 0.5f * object.size.y();
      if (wall == 3) foot.x() = room.size.x() - kGap - 0.5f * object.size.y();
      foot.z() = number(random, 0.4, 1.5);
    }
    room.objects.push_back(place(random, object, foot, yaw, plain));
  }

  for (int i = 1 + choose(random, 3); i > 0; --i)
    room.lamps.emplace_back(number(random, 0.2, room.size.x() - 0.2),
                            number(random, 0.2, room.size.y() - 0.2),
                            room.size.z() - number(random, 0.1, 1.2));
  room.ambient = number(random, 0.2, 0.7);
  room.shadows = !plain || chance(random, 0.2);
  return room;
}

}  // namespace edge_mcl
