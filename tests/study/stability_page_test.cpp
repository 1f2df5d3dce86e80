// The page of the stability suite: self-contained, complete, and honest about a bound not kept.
#include "apps/study/stability/stability_page.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "tests/support/temporary_folder.h"

namespace cosplat {
namespace {

StabilityCase SmallCase(double ours) {
  StabilityCase s;
  s.key = "small_case";
  s.title = "A case with <angles>";
  s.what = "What goes wrong & how.";
  s.quantity = "things that are wrong";
  s.unit = "px";
  s.naive = {"the naive form", INFINITY, Image8(8, 6, 3, 200)};
  s.ours = {"our form", ours, Image8(8, 6, 3, 20)};
  s.bound = 12345;
  s.chart = {"angle", "rad", "error", "", false, true, {{"a curve", {{0, 1}, {1, NAN}, {2, 3}}}}};
  return s;
}

StabilityResults Results(double ours) {
  return {"a machine", {{"polynomials", {{0, 1e-8, 0.5}, {1, 2e-8, 1.5}}}}, {SmallCase(ours)}};
}

TEST(StabilityPage, ShowsBothFormsAndTheBound) {
  const std::string html = StabilityHtml(Results(0.000123));
  for (const char* text : {"A case with &lt;angles&gt;",
                           "goes wrong &amp; how",
                           "the naive form",
                           "infinite",
                           "our form",
                           "1.23e-4 px",
                           "at most 12,345 px",
                           "id=\"small_case\"",
                           "href=\"#small_case\"",
                           "a machine",
                           "<svg",
                           "data:image/png;base64,iVBOR"})
    EXPECT_NE(html.find(text), std::string::npos) << text;
  EXPECT_EQ(html.find("not kept"), std::string::npos);
  for (const char* outside : {"src=\"http", "href=\"http", "<script", "<link"})
    EXPECT_EQ(html.find(outside), std::string::npos) << outside;
}

TEST(StabilityPage, SaysWhenABoundIsNotKept) {
  EXPECT_NE(StabilityHtml(Results(1e6)).find("not kept"), std::string::npos);
  EXPECT_NE(StabilityHtml(Results(NAN)).find("not kept"), std::string::npos);
}

TEST(StabilityPage, JsonHasNullForWhatIsNoNumber) {
  const nlohmann::ordered_json json = StabilityJson(Results(2));
  const auto& s = json["cases"][0];
  EXPECT_TRUE(s["naive"]["value"].is_null());
  EXPECT_EQ(s["ours"]["value"], 2);
  EXPECT_EQ(s["bound_is"], "at most");
  EXPECT_EQ(s["ours_within_bound"], true);
  EXPECT_TRUE(s["curves"][0]["points"][1][1].is_null());
  EXPECT_EQ(json["forms"][0]["points"][1]["ns"], 1.5);
}

TEST(StabilityPage, ChartsErrorAgainstTime) {
  const Chart chart = FormsChart(Results(1).forms);
  EXPECT_TRUE(chart.x.log && chart.y.log);
  EXPECT_EQ(chart.series[0].marks[1].label, "1");
  EXPECT_EQ(chart.series[0].marks[1].x, 1.5);
}

}  // namespace
}  // namespace cosplat
