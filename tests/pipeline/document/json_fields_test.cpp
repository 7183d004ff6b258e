#include "pipeline/document/json_schema.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace lightcook::pipeline {
namespace {

struct Seed {
    double mass = 0;
    std::optional<std::string> colour;
};
template <class Fields, Is<Seed> Self>
void describe(Fields& fields, Self& seed) {
    fields.required("mass", seed.mass, kFigure, "mass [g]");
    fields.optional("colour", seed.colour, "name of its colour");
}

struct Fruit {
    std::string name;
    int count = 0;
    std::vector<Seed> seeds;
    std::optional<Seed> core;
    std::map<std::string, double> prices;
    glm::vec3 size{0};
    bool isRipe = false;
    std::string shelf;
};
template <class Fields, Is<Fruit> Self>
void describe(Fields& fields, Self& fruit) {
    fields.required("name", fruit.name, "name of the sort");
    fields.required("count", fruit.count, between(1, 9), "number of pieces");
    fields.required("seeds", fruit.seeds, atLeast(1), "seeds of one piece");
    fields.optional("core", fruit.core, "largest seed");
    fields.required("prices", fruit.prices, between(0, 100), "price by shop");
    fields.required("size", fruit.size, "edges of its box [cm]");
    fields.object("state", "what it is like today", [&](auto& state) { state.required("ripe", fruit.isRipe, "true if it can be eaten"); });
    fields.presentIf(!fruit.shelf.empty(), "shelf", fruit.shelf, "where it lies");
}

Json fruitJson() {
    return {{"name", "pear"},
            {"count", 2},
            {"seeds", {{{"mass", 0.5}, {"colour", "black"}}, {{"mass", nullptr}}}},
            {"prices", {{"corner", 1.5}}},
            {"size", {1.0, 2.0, 3.0}},
            {"state", {{"ripe", true}}}};
}

TEST(JsonFields, AreWrittenAsTheyWereRead) {
    const Json json = fruitJson();
    const auto fruit = fromJson<Fruit>(json, "basket");
    ASSERT_TRUE(fruit.has_value()) << fruit.error().line();
    EXPECT_EQ(fruit->seeds.at(1).mass, HUGE_VAL);
    EXPECT_EQ(fruit->size, glm::vec3(1, 2, 3));
    EXPECT_EQ(toJson(*fruit).dump(), json.dump());
}

TEST(JsonFields, ThePathOfAWrongValueIsNamed) {
    const auto lineWith = [](const char* pointer, const Json& value) {
        Json json = fruitJson();
        json[Json::json_pointer(pointer)] = value;
        const auto fruit = fromJson<Fruit>(json, "basket");
        return fruit ? std::string("accepted") : fruit.error().line();
    };
    EXPECT_THAT(lineWith("/name", 3), testing::HasSubstr("basket, name: found 3, expected a string"));
    EXPECT_THAT(lineWith("/count", 10), testing::HasSubstr("basket, count: found 10, expected an integer from 1 to 9"));
    EXPECT_THAT(lineWith("/count", 2.5), testing::HasSubstr("expected an integer"));
    EXPECT_THAT(lineWith("/seeds/1/mass", -1), testing::HasSubstr("basket, seeds/1/mass: found -1, expected a number from 0"));
    EXPECT_THAT(lineWith("/seeds", Json::array()), testing::HasSubstr("expected a list of at least 1"));
    EXPECT_THAT(lineWith("/prices/corner", "dear"), testing::HasSubstr("basket, prices/corner"));
    EXPECT_THAT(lineWith("/size", {1, 2}), testing::HasSubstr("basket, size: found [1,2], expected a list of 3"));
    EXPECT_THAT(lineWith("/state", Json::object()),
                testing::HasSubstr("basket, state: found {}, expected an object with a member \"ripe\""));
}

TEST(JsonSchema, HasEachStructOnceAndRefersToIt) {
    const Json schema = documentSchema<Fruit>("basket");
    const Json& properties = schema.at("properties");
    EXPECT_EQ(properties.at("count"), Json({{"type", "integer"}, {"minimum", 1.0}, {"maximum", 9.0}, {"description", "number of pieces"}}));
    EXPECT_EQ(properties.at("seeds").at("items"), Json({{"$ref", "#/$defs/Seed"}}));
    EXPECT_EQ(properties.at("core").at("$ref"), "#/$defs/Seed");
    EXPECT_EQ(properties.at("core").at("description"), "largest seed");
    EXPECT_EQ(properties.at("state").at("properties").at("ripe").at("type"), "boolean");
    EXPECT_EQ(schema.at("required"), Json({"name", "count", "seeds", "prices", "size", "state"}));
    ASSERT_EQ(schema.at("$defs").size(), 1u);
    EXPECT_EQ(schema.at("$defs").at("Seed").at("required"), Json({"mass"}));
    EXPECT_EQ(schema.at("$defs").at("Seed").at("additionalProperties"), false);
}

}  // namespace
}  // namespace lightcook::pipeline
