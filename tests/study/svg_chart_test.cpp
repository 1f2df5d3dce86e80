// apps/charts/svg_chart.h: what is drawn is what was given, in XML that any reader takes.
#include "apps/charts/svg_chart.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "apps/charts/chart_scale.h"
#include "tests/study/well_formed.h"

namespace cosplat::test {
namespace {

size_t Count(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(ChartScale, EndsOnRoundNumbers) {
  const ChartScale linear({0.3, 8.7}, false, false);
  EXPECT_EQ(linear.ticks(), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  EXPECT_DOUBLE_EQ(linear(5), 0.5);
  const ChartScale high({21.2, 24.9}, false, false);
  EXPECT_EQ(high.ticks(), (std::vector<double>{21, 22, 23, 24, 25}));
  EXPECT_EQ(ChartScale({21.2, 24.9}, false, true).ticks()[0], 0);
  const ChartScale log({1000, 1e6}, true, false);
  ASSERT_EQ(log.ticks().size(), 4u);
  EXPECT_NEAR(log(31622.7766), 0.5, 1e-6);
  EXPECT_EQ(ChartScale({3, 40}, true, false).ticks(), (std::vector<double>{2, 5, 10, 20, 50}));
}

TEST(ChartScale, HoldsWhateverItIsGiven) {
  for (const bool log : {false, true})
    for (const std::vector<double>& values :
         {std::vector<double>{}, {5}, {5, 5}, {1e-9, 2e-9}, {1e12, 1.0001e12}}) {
      const ChartScale scale(values, log, false);
      ASSERT_GE(scale.ticks().size(), 2u);
      EXPECT_LE(scale.ticks().size(), 9u);
      for (const double v : values) {
        EXPECT_GE(scale(v), -1e-9);
        EXPECT_LE(scale(v), 1 + 1e-9);
      }
    }
}

TEST(ChartScale, TicksAreToldApart) {
  using Texts = std::vector<std::string>;
  EXPECT_EQ(TickTexts({0, 0.5, 1}), (Texts{"0", "0.5", "1"}));
  EXPECT_EQ(TickTexts({34.95, 35, 35.05}), (Texts{"34.95", "35", "35.05"}));
  EXPECT_EQ(TickTexts({1e6, 1.0005e6, 1.001e6}), (Texts{"1M", "1.0005M", "1.001M"}));
}

TEST(ChartScale, NumbersAreShort) {
  EXPECT_EQ(ShortNumber(0), "0");
  EXPECT_EQ(ShortNumber(0.25), "0.25");
  EXPECT_EQ(ShortNumber(1500), "1.5k");
  EXPECT_EQ(ShortNumber(1e6), "1M");
}

TEST(SvgChart, DrawsEveryPointAndEscapesItsNames) {
  Chart chart{Chart::Kind::kLines, "a < b & \"c\"", {"x", "px", true}, {"y", ""}, {}, {}};
  chart.series = {{"one", {{1, 2, "first"}, {10, 3, ""}}}, {"two", {{100, 4, ""}}}};
  chart.guides = {{"guide", {{1, 0.1, ""}, {100, 400, ""}}}};
  const std::string svg = ToSvg(chart);
  EXPECT_EQ(ProblemOfXml(svg), "");
  EXPECT_EQ(Count(svg, "<circle"), 3u);
  EXPECT_EQ(Count(svg, "<polyline"), 2u);
  for (const std::string text :
       {">a &lt; b &amp; &quot;c&quot;<", ">x (px)<", ">first<", ">guide<"})
    EXPECT_EQ(Count(svg, text), 1u) << text;
  chart.kind = Chart::Kind::kPoints;
  EXPECT_EQ(Count(ToSvg(chart), "<polyline"), 0u);
}

// A bar and two caps each; an error that reaches below zero has no lower end on a logarithmic axis.
TEST(SvgChart, DrawsErrorBarsAndRings) {
  Chart chart{Chart::Kind::kPoints, "t", {"x", "", true}, {"y", ""}, {}, {}};
  chart.series = {{"s", {{1, 2, ""}, {10, 3, ""}}}};
  const size_t circles = Count(ToSvg(chart), "<circle");
  chart.series[0].marks[0].x_error = 5;
  chart.series[0].marks[1].y_error = 0.5;
  chart.series[0].marks[1].ringed = true;
  const std::string svg = ToSvg(chart);
  EXPECT_EQ(ProblemOfXml(svg), "");
  EXPECT_EQ(Count(svg, "<circle"), circles + 1);
  EXPECT_EQ(Count(svg, "stroke=\"#0072b2\""), 6u);
  EXPECT_EQ(Count(svg, "nan") + Count(svg, "inf"), 0u);
  chart.y.log = true;
  chart.series[0].marks[1].y_error = 3;
  EXPECT_EQ(Count(ToSvg(chart), "nan") + Count(ToSvg(chart), "inf"), 0u);
}

// The bars' ends are within the plot: the axis covers them.
TEST(SvgChart, AxesCoverErrorBars) {
  Chart chart{Chart::Kind::kPoints, "t", {"x", ""}, {"y", ""}, {}, {}};
  chart.series = {{"s", {{1, 10, ""}, {2, 11, ""}}}};
  EXPECT_EQ(Count(ToSvg(chart), ">16<"), 0u);
  chart.series[0].marks[1].y_error = 4;
  EXPECT_EQ(Count(ToSvg(chart), ">16<"), 1u);
}

TEST(SvgChart, TellsMoreSeriesApartThanThereAreColors) {
  Chart chart{Chart::Kind::kPoints, "t", {"x", ""}, {"y", ""}, {}, {}};
  for (int i = 0; i < 8; ++i)
    chart.series.push_back({std::string(1, char('a' + i)), {{double(i), 1, ""}}});
  EXPECT_EQ(Count(ToSvg(chart), "fill=\"#ffffff\" stroke=\"#0072b2\""), 2u);  // legend and point
}

TEST(SvgChart, DrawsABarPerCategoryAndSeries) {
  Chart chart{Chart::Kind::kBars, "bars", {"time", "ms"}, {}, {}, {}};
  chart.series = {{"one", {{1, 0, "a"}, {2, 0, "b"}}}, {"two", {{3, 0, "b"}, {4, 0, "c"}}}};
  const std::string svg = ToSvg(chart);
  EXPECT_EQ(ProblemOfXml(svg), "");
  EXPECT_EQ(Count(svg, "<rect"), 1u + 2u + 4u);  // paper, legend, bars
  for (const std::string text : {">a<", ">b<", ">c<", ">time (ms)<"})
    EXPECT_EQ(Count(svg, text), 1u) << text;
  chart.x.log = true;
  EXPECT_EQ(Count(ToSvg(chart), "<circle"), 4u);
}

TEST(SvgChart, LeavesOutWhatHasNoPlace) {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  for (const Chart::Kind kind : {Chart::Kind::kLines, Chart::Kind::kBars}) {
    Chart chart{kind, "t", {"x", "", true}, {"y", "", true}, {}, {}};
    EXPECT_EQ(ProblemOfXml(ToSvg(chart)), "");
    chart.series = {{"s", {{nan, 1, "a"}, {inf, 1, "b"}, {-1, 1, "c"}, {0, 1, "d"}}}};
    const std::string svg = ToSvg(chart);
    EXPECT_EQ(ProblemOfXml(svg), "");
    EXPECT_EQ(Count(svg, "nan") + Count(svg, "inf") + Count(svg, "<circle"), 0u);
  }
}

}  // namespace
}  // namespace cosplat::test
