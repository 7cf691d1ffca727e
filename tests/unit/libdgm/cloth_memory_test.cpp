// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/cloth_memory_test.cpp
// What cloth remembers of the things around it changes no bit.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "asked.h"
#include "cloth_obstacles.h"
#include "dice.h"

namespace dgm::test {
namespace {

/// From now on nothing that was seen tells of the next substeps.
void forget(detail::ClothImpl& c) {
    c.near_tiles = {};
    c.scene_way = std::numeric_limits<double>::quiet_NaN();
}

TEST(ClothMemory, OfWhatWasSeenBeforeChangesNoBit) {
    // On a closed ball and on an open sheet that lets through what is far behind it; the ball moves for a while.
    const auto fall = [](bool remembers) {
        ClothOptions o;
        o.self_contact = true;
        o.thickness = 4e-3f;
        Drape d(grid_chart(33, 33,
                           [](double i, double j) {
                               return Point{float(i / 40 - 0.4), float(j / 40 - 0.4), 0.31f};
                           }),
                o);
        State ball = make_state(closed_chart(33, [](std::array<double, 3> n) -> std::array<double, 3> {
            return {0.2 * n[0], 0.2 * n[1], 0.3 * n[2]};
        }));
        State floor = make_state(grid_chart(17, 17, [](double i, double j) {
            return Point{float(i / 8 - 1), float(j / 8 - 1), float(-0.1 + 0.02 * std::sin(i))};
        }));
        Obstacle things[] = {{.kind = ObstacleKind::Surface, .surface = &ball},
                             {.kind = ObstacleKind::Surface, .surface = &floor},
                             {.kind = ObstacleKind::Sphere, .point = {0.3f, 0.3f, 0}, .radius = 0.1f}};
        d.how.obstacles = things;
        d.how.friction = 0.5f;
        detail::ClothImpl& c = *d.cloth.impl();
        if (!remembers) forget(c);
        for (int k = 0; k < 90; ++k) {
            if (k >= 30 && k < 50) things[0].point.x += 0.004f;
            d.run(1);
        }
        EXPECT_GT(c.contact_count, 100u);
        const PointView now = d.state.positions();
        return std::vector<float>(now.x, now.x + now.count);
    };
    const std::vector<float> a = fall(true), b = fall(false);
    EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(float)), 0);
}

ChartSpec egg_chart(std::uint32_t side) {
    return closed_chart(side, [](std::array<double, 3> n) {
        return std::array<double, 3>{0.2 * n[0], 0.1 * n[1], 0.1 * n[2]};
    });
}
/// Turned about y.
void turn(Obstacle& o, double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    const double r[9] = {c, 0, s, 0, 1, 0, -s, 0, c};
    std::transform(r, r + 9, o.rotation, [](double x) { return float(x); });
}

/// It hovers.
Drape level_sheet(const ClothOptions& options = {}) {
    Drape d(grid_chart(33, 33,
                       [](double i, double j) {
                           return Point{float(i / 64 - 0.25), float(j / 64 - 0.25), 0.12f};
                       }),
            options);
    d.how.gravity = {};
    return d;
}
std::vector<float> heights(const Drape& d) {
    const PointView now = d.state.positions();
    return {now.z, now.z + now.count};
}

TEST(ClothMemory, OfMovingThingsChangesNoBit) {
    // Each goes its own way, turns or grows, beside a ball that stays; the skin bends, with and without telling how it
    // was; reach changes. Nothing pulls, so that what comes is met by cloth that has been seen to be clear.
    using Path = std::function<void(Obstacle&, int)>;
    const auto fall = [](Obstacle thing, const Path& path, Skin* skin, bool remembers) {
        Drape d = level_sheet();
        if (skin != nullptr) thing = obstacle_of(*skin);
        Obstacle both[] = {thing, ball({0.2f, 0.2f, 0}, 0.1f)};
        d.how.obstacles = both;
        d.how.friction = 0.5f;
        if (!remembers) forget(*d.cloth.impl());
        std::uint32_t most = 0;
        for (int k = 0; k < 45; ++k) {
            path(both[0], k);
            most = std::max(most, d.run(1).contacts);
        }
        EXPECT_GT(most, 0u);
        return heights(d);
    };
    const Obstacle box = box_of({0.12f, 0.12f, 0.05f});
    const Obstacle capsule = capsule_between({-0.2f, 0, 0}, {0.2f, 0, 0}, 0.06f);
    const struct {
        const char* what;
        Obstacle thing;
        Path path;
    } all[] = {
        {"a ball that grows", ball({0, 0, -0.05f}, 0.1f), [](Obstacle& o, int) { o.radius += 0.002f; }},
        {"a ball that comes", ball({-0.4f, 0, 0.05f}, 0.1f), [](Obstacle& o, int) { o.point.x += 0.01f; }},
        {"a capsule that swings", capsule, [](Obstacle& o, int k) { o.end.z = float(0.1 * std::sin(0.2 * k)); }},
        {"a box that turns", box, [](Obstacle& o, int k) { turn(o, 0.05 * k); }},
        {"a plane that turns", plane({0, 0, 0}, {0, 0, 1}), [](Obstacle& o, int k) { o.normal.x = float(0.02 * k); }},
        {"a plane that rises", plane({0, 0, 0}, {0, 0, 1}), [](Obstacle& o, int) { o.point.z += 0.004f; }},
        {"a plane from the side", plane({0.29f, 0.29f, 0}, {-1, -1, -0.5f}),
         [](Obstacle& o, int k) { o.point.x -= k < 2 ? 0 : 0.012f; }},
    };
    for (const auto& one : all) {
        SCOPED_TRACE(one.what);
        const std::vector<float> a = fall(one.thing, one.path, nullptr, true),
                                 b = fall(one.thing, one.path, nullptr, false);
        EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(float)), 0);
    }
    for (const bool known : {false, true}) {
        SCOPED_TRACE(known);
        std::vector<float> shape[2];
        for (const bool remembers : {false, true}) {
            Skin skin(egg_chart(33));
            const Path path = [&](Obstacle& o, int k) {
                if (!known) turn(o, 0.02 * k);
                o.point.z = 0;
                o.reach = k < 10 ? 0.03f : 0;
                if (k < 5 || k % 10 > 6) return;
                skin.lead([&](Vec3 v) { return Vec3{v.x, v.y, v.z * (1 + 0.0004f * k * k)}; });
                o.before = known ? skin.shape_before() : PointView{};
            };
            shape[remembers ? 1 : 0] = fall({}, path, &skin, remembers);
        }
        EXPECT_EQ(std::memcmp(shape[0].data(), shape[1].data(), shape[0].size() * sizeof(float)), 0);
    }
}

TEST(ClothMemory, OfToolsThatGrowChangesNoBit) {
    // A tool that stays, and from time to time has a larger radius at once.
    const auto grow = [](bool remembers) {
        Drape d = level_sheet();
        d.how.tool_radius = 0.06f;
        const ToolInput tool{.position = {0, 0, 0}, .engaged = true};
        if (!remembers) forget(*d.cloth.impl());
        std::uint32_t most = 0;
        for (int k = 0; k < 24; ++k) {
            if (k % 4 == 3) d.how.tool_radius += 0.015f;
            most = std::max(most, step(d.state, d.cloth, d.how, {&tool, 1}).value().contacts);
        }
        EXPECT_GT(most, 0u);
        return heights(d);
    };
    const std::vector<float> a = grow(true), b = grow(false);
    EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(float)), 0);
}

TEST(ClothMemory, OfForcesEndsWhereNothingIsNear) {
    // A tool presses, is taken away and comes back to touch, or a table goes and comes. What came first must not count.
    const auto touched_again = [](bool by_tool, bool clears) {
        Drape d = level_sheet();
        d.pin_rows(0, 1);
        d.pin_rows(32, 1);
        d.how.tool_radius = 0.03f;
        ToolInput tool{.position = {0, 0, 0.085f}, .engaged = true};
        Obstacle table = ball({0, 0, 0.085f}, 0.03f);
        const auto frames = [&](int count, bool there) {
            d.how.pins = d.pins;
            d.how.obstacles = {&table, there && !by_tool ? 1u : 0u};
            std::uint32_t contacts = 0;
            for (int k = 0; k < count; ++k)
                contacts = step(d.state, d.cloth, d.how, {&tool, there && by_tool ? 1u : 0u}).value().contacts;
            return contacts;
        };
        frames(1, false);
        tool.position.z = table.point.z = 0.1f;
        EXPECT_GT(frames(20, true), 0u);
        tool.position.z = table.point.z = -0.5f;
        frames(10, by_tool);
        EXPECT_EQ(frames(100, false), 0u);
        detail::ClothImpl& c = *d.cloth.impl();
        if (clears) std::fill(c.pressed, c.pressed + c.fine().count, 0.0f);
        tool.position.z = table.point.z = float(d.at(16, 16).z - 0.0295);
        frames(1, true);
        return heights(d);
    };
    for (const bool by_tool : {false, true}) {
        const std::vector<float> a = touched_again(by_tool, false), b = touched_again(by_tool, true);
        EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(float)), 0) << by_tool;
    }
}

/// Things that come and go, turn, grow, jump and bend as chance has it.
class AnyScene {
 public:
    explicit AnyScene(std::uint64_t seed) : dice_(seed) {
        const std::uint32_t count = dice_.between(1, 4);
        for (std::uint32_t k = 0; k < count; ++k) things_.push_back(any());
    }
    [[nodiscard]] std::span<const Obstacle> things() const { return things_; }
    [[nodiscard]] Dice& dice() { return dice_; }
    void go_on() {
        for (Obstacle& o : things_) {
            o.before = {};
            if (!dice_.one_in(3)) move(o);
        }
        if (dice_.one_in(25) && things_.size() < 6) things_.insert(things_.begin() + dice_.below(size()), any());
        if (dice_.one_in(25) && things_.size() > 1) things_.erase(things_.begin() + dice_.below(size()));
    }

 private:
    [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(things_.size()); }
    Obstacle any() {
        const Vec3 at{dice_.real(-0.2f, 0.2f), dice_.real(-0.2f, 0.2f), dice_.real(-0.1f, 0.05f)};
        switch (dice_.below(5)) {
            case 0:
                return plane({0, 0, dice_.real(-0.1f, 0.05f)}, {dice_.real(-0.2f, 0.2f), dice_.real(-0.2f, 0.2f), 1});
            case 1:
                return ball(at, dice_.real(0.03f, 0.12f));
            case 2:
                return capsule_between(at, {dice_.real(-0.2f, 0.2f), dice_.real(-0.2f, 0.2f), -0.05f},
                                       dice_.real(0.02f, 0.08f));
            case 3: {
                Obstacle box = box_of({dice_.real(0.03f, 0.15f), dice_.real(0.03f, 0.15f), dice_.real(0.02f, 0.08f)});
                box.point = at;
                return box;
            }
            default: {
                if (skins_.size() < 2 || dice_.one_in(2))
                    skins_.push_back(dice_.one_in(2) ? std::make_unique<Skin>(egg_chart(17))
                                                     : std::make_unique<Skin>());
                Obstacle o = obstacle_of(*skins_[dice_.below(static_cast<std::uint32_t>(skins_.size()))]);
                o.point.z = dice_.real(-0.15f, 0);
                return o;
            }
        }
    }
    void move(Obstacle& o) {
        const float step = dice_.one_in(20) ? 0.2f : 0.01f;
        o.point.x += dice_.real(-step, step);
        o.point.y += dice_.real(-step, step);
        o.point.z += dice_.real(-step, step);
        if (o.kind == ObstacleKind::Capsule) o.end.z += dice_.real(-0.01f, 0.01f);
        if (o.radius > 0) o.radius = std::max(0.01f, o.radius + dice_.real(-0.004f, 0.005f));
        if (o.kind == ObstacleKind::Box || o.kind == ObstacleKind::Surface) turn(o, double{dice_.real(-0.1f, 0.1f)});
        if (o.kind == ObstacleKind::Plane) o.normal.x += dice_.real(-0.03f, 0.03f);
        if (o.kind != ObstacleKind::Surface) return;
        if (dice_.one_in(10)) o.reach = dice_.one_in(2) ? 0 : dice_.real(0.01f, 0.1f);
        if (!dice_.one_in(4)) return;
        for (const auto& skin : skins_) {
            if (&skin->led.state != o.surface) continue;
            const float by = dice_.real(-0.03f, 0.03f);
            skin->lead([=](Vec3 v) { return Vec3{v.x, v.y, v.z * (1 + by) + by * v.x}; });
            if (dice_.one_in(2)) o.before = skin->shape_before();
        }
    }

    Dice dice_;
    std::vector<std::unique_ptr<Skin>> skins_;
    std::vector<Obstacle> things_;
};

/// @return  heights after each frame
std::vector<float> shapes_in(std::uint32_t seed, bool remembers, std::uint32_t& contacts) {
    AnyScene scene(seed);
    Dice& dice = scene.dice();
    ClothOptions o;
    o.self_contact = dice.one_in(2);
    Drape d = level_sheet(o);
    d.how.friction = dice.real(0, 0.6f);
    d.how.gravity = {0, 0, dice.one_in(2) ? 0.0f : -2.0f};
    if (dice.one_in(2)) d.pin_rows(0, 1);
    if (!remembers) forget(*d.cloth.impl());
    std::vector<float> out;
    ToolInput tool{.position = {0, 0, 0.2f}, .engaged = true};
    for (int k = 0; k < 40; ++k) {
        scene.go_on();
        d.how.obstacles = scene.things();
        d.how.substeps = dice.one_in(10) ? 3 : 8;
        d.how.tool_radius = dice.real(0.02f, 0.06f);
        d.how.pins = d.pins;
        tool.position = {dice.real(-0.3f, 0.3f), dice.real(-0.3f, 0.3f), dice.real(0, 0.2f)};
        const bool with_tool = dice.one_in(3);
        const auto done = step(d.state, d.cloth, d.how, {&tool, with_tool ? 1u : 0u});
        EXPECT_TRUE(done.ok()) << done.error().message;
        contacts += done.value().contacts;
        const std::vector<float> now = heights(d);
        out.insert(out.end(), now.begin(), now.end());
    }
    return out;
}

TEST(ClothMemory, ChangesNoBitInAnyScene) {
    const auto seeds = static_cast<std::uint32_t>(asked("DGM_TEST_SEEDS", 3));
    std::uint32_t contacts = 0;
    for (std::uint32_t seed = 0; seed < seeds; ++seed) {
        SCOPED_TRACE(seed);
        const std::vector<float> a = shapes_in(seed, true, contacts), b = shapes_in(seed, false, contacts);
        const auto differ = std::mismatch(a.begin(), a.end(), b.begin());
        EXPECT_TRUE(differ.first == a.end()) << "frame " << (differ.first - a.begin()) / (33 * 33);
    }
    EXPECT_GT(contacts, 100 * seeds);
}

}  // namespace
}  // namespace dgm::test
