#include "server/net/http/scene_paths.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace foreland::server {
namespace {

const std::vector<std::string> kNames = {"hills", "alps.2", "hill"};

TEST(ScenePaths, EachSceneIsBelowItsNameAlone) {
  for (size_t i = 0; i < kNames.size(); ++i)
    for (const char* rest : {"", "/", "/fly", "/assets/a.js", "//", "/../x"}) {
      const std::string path = "/" + kNames[i] + rest;
      const auto found = scenePathOf(path, kNames);
      ASSERT_TRUE(found) << path;
      EXPECT_EQ(found->scene, i) << path;
      EXPECT_EQ(found->rest, rest) << path;
    }
  for (const char* path :
       {"", "/", "/fly", "hills/", "//hills/", "/hillsx/", "/Hills/", "/hil", "/..", "/alps", "/?hills"})
    EXPECT_FALSE(scenePathOf(path, kNames)) << path;
}

TEST(ScenePaths, OneSceneHasAllPaths) {
  for (const char* path : {"", "/", "/fly", "/hills/fly"}) {
    const auto found = scenePathOf(path, {});
    ASSERT_TRUE(found);
    EXPECT_EQ(found->scene, 0u);
    EXPECT_EQ(found->rest, path);
    EXPECT_EQ(sceneToFly(path, {}), 0u);
  }
}

TEST(ScenePaths, ViewersFlyWhereTheyAreToldTo) {
  for (const char* target : {"/alps.2/fly", "/alps.2/", "/alps.2", "/alps.2/fly?token=a/hills/fly"})
    EXPECT_EQ(sceneToFly(target, kNames), 1u) << target;
  for (const char* target :
       {"/fly", "/", "/alps.2/flyx", "/alps.2/fly/", "/alps.2/assets", "/alps/fly", "/?/alps.2/fly"})
    EXPECT_FALSE(sceneToFly(target, kNames)) << target;
}

TEST(ScenePaths, RefusesNamesThatWouldNotDo) {
  EXPECT_TRUE(checkSceneNames(kNames).ok());
  EXPECT_TRUE(checkSceneNames({}).ok());
  const std::vector<std::vector<std::string>> bad = {{""},
                                                     {"a b"},
                                                     {"a/b"},
                                                     {".."},
                                                     {".hidden"},
                                                     {"\xc3\xa4"},
                                                     {"a%20"},
                                                     {"fly"},
                                                     {"metrics"},
                                                     {"assets"},
                                                     {"scenes"},
                                                     {"livez"},
                                                     {"hills", "alps", "hills"},
                                                     {std::string(65, 'a')},
                                                     {"<b>"},
                                                     {"a\"b"},
                                                     {"a?"},
                                                     {std::string("a\0b", 3)}};
  for (const std::vector<std::string>& names : bad) {
    const Status status = checkSceneNames(names);
    ASSERT_FALSE(status.ok()) << names.front();
    EXPECT_NE(status.error().message.find("rename"), std::string::npos) << status.error().message;
  }
}

}  // namespace
}  // namespace foreland::server
