#include "edge_mcl/core/base/random_source.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <vector>

namespace edge_mcl {
namespace {

/// Largest difference between the distribution of the numbers and a distribution function
/// (Kolmogorov's statistic).
double kolmogorov(std::vector<double> numbers, const std::function<double(double)>& distribution) {
  std::sort(numbers.begin(), numbers.end());
  const auto count = static_cast<double>(numbers.size());
  double most = 0;
  for (size_t i = 0; i < numbers.size(); ++i) {
    const double expected = distribution(numbers[i]);
    most = std::max({most, std::abs(static_cast<double>(i) / count - expected),
                     std::abs(static_cast<double>(i + 1) / count - expected)});
  }
  return most;
}

/// Numbers of the right distribution exceed this limit of Kolmogorov's statistic with the
/// probability 2 exp(-2 * 1.95^2) = 0.001.
double limitFor(size_t count) { return 1.95 / std::sqrt(static_cast<double>(count)); }

double normalDistribution(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

/// The C++ standard ([rand.predef]) gives the 10000th number of the engine with the default seed
/// 5489.
TEST(RandomSource, TheSequenceIsThatOfTheCppStandard) {
  RandomSource random(5489);
  for (int i = 1; i < 10000; ++i) random.uniform();
  constexpr uint64_t kTenThousandth = 9981545732273789042u;
  EXPECT_EQ(random.uniform(), std::ldexp(static_cast<double>(kTenThousandth >> 11), -53));
}

TEST(RandomSource, TheSeedDecidesTheSequence) {
  RandomSource first(1), second(1), other(2);
  int equal = 0;
  for (int i = 0; i < 100; ++i) {
    const double number = first.normal();
    EXPECT_EQ(number, second.normal());
    equal += number == other.normal();
  }
  EXPECT_EQ(equal, 0);
}

TEST(RandomSource, UniformNumbersCoverZeroToOneEvenly) {
  RandomSource random(1);
  std::vector<double> numbers(100000);
  for (double& number : numbers) {
    number = random.uniform();
    ASSERT_GE(number, 0);
    ASSERT_LT(number, 1);
  }
  EXPECT_LT(kolmogorov(numbers, [](double x) { return x; }), limitFor(numbers.size()));
}

/// The truth is the distribution function of the standard normal distribution.
TEST(RandomSource, NormalNumbersAreStandardNormal) {
  RandomSource random(2);
  std::vector<double> numbers(100000);
  for (double& number : numbers) number = random.normal();
  EXPECT_LT(kolmogorov(numbers, normalDistribution), limitFor(numbers.size()));
}

/// The polar method makes two numbers from one pair of uniform numbers. The test computes them from
/// the uniform numbers of the same seed.
TEST(RandomSource, NormalNumbersComeFromThePolarMethod) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    RandomSource random(seed), uniform(seed);
    double u = 0, v = 0, s = 2;
    while (s >= 1) {
      u = 2 * uniform.uniform() - 1;
      v = 2 * uniform.uniform() - 1;
      s = u * u + v * v;
    }
    const double radius = std::sqrt(-2 * std::log(s));
    // The formula is arranged in another way, so the last bits differ.
    EXPECT_NEAR(random.normal(), radius * u / std::sqrt(s), 1e-14);
    EXPECT_NEAR(random.normal(), radius * v / std::sqrt(s), 1e-14);
    EXPECT_EQ(random.uniform(), uniform.uniform());
  }
}

/// The sum of the squares of six independent standard normal numbers has a chi-squared
/// distribution with six degrees of freedom. Its distribution function is a closed form.
TEST(RandomSource, ATwistHasSixIndependentNormalNumbers) {
  RandomSource random(3);
  constexpr int kCount = 20000;
  std::vector<double> squares;
  Matrix6 products = Matrix6::Zero();
  for (int i = 0; i < kCount; ++i) {
    const Twist xi = random.normalTwist();
    squares.push_back(xi.squaredNorm());
    products += xi * xi.transpose() / kCount;
  }
  const auto chi_squared = [](double x) { return 1 - std::exp(-x / 2) * (1 + x / 2 + x * x / 8); };
  EXPECT_LT(kolmogorov(squares, chi_squared), limitFor(squares.size()));
  // An entry of the mean has a standard deviation of at most sqrt(2 / count) = 0.01. Five of them
  // are allowed.
  EXPECT_LT((products - Matrix6::Identity()).cwiseAbs().maxCoeff(), 0.05);
}

/// On a sphere of radius 1 the coordinate along any axis is uniform in [-1, 1] (Archimedes).
TEST(RandomSource, DirectionsAreUniformOnTheSphere) {
  RandomSource random(4);
  std::vector<Eigen::Vector3d> directions(20000);
  for (Eigen::Vector3d& d : directions) {
    d = random.direction();
    ASSERT_NEAR(d.norm(), 1, 1e-12);  // rounding of the normalisation
  }
  for (const Eigen::Vector3d& axis :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1),
        Eigen::Vector3d(Eigen::Vector3d(1, -2, 3).normalized())}) {
    std::vector<double> along;
    along.reserve(directions.size());
    for (const Eigen::Vector3d& d : directions) along.push_back(axis.dot(d));
    EXPECT_LT(kolmogorov(along, [](double x) { return (1 + x) / 2; }), limitFor(along.size()))
        << axis.transpose();
  }
}

}  // namespace
}  // namespace edge_mcl
