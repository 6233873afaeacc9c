#include "io/pose_table_file.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/error.h"

namespace slipstream::pose_table_file_test {

using Row = std::vector<double>;

PoseTable lines(const std::string& text, const std::string& columns = "") {
  return pose_table_in_text(text, false, columns, "robot.csv");
}

PoseTable yaml(const std::string& text) {
  return pose_table_in_text(text, true, "", "robot.yaml");
}

void expect_refused(const std::string& text, const std::string& part) {
  try {
    lines(text);
    ADD_FAILURE() << text;
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

TEST(PoseTableFile, FindsColumnsByTheirNames) {
  const PoseTable table = lines(
      "time,Name,RX [deg],RY [deg],RZ [deg],X [mm],Y [mm],Z [mm]\n0.5,one,4,5,6,1,2,3\n"
      "1.5,two,40,50,60,10,20,30\n");
  EXPECT_EQ(table.rows[0], (Row{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(table.rows[1], (Row{10, 20, 30, 40, 50, 60}));
  EXPECT_EQ(table.names, (std::vector<std::string>{"one", "two"}));

  EXPECT_EQ(lines("qx qy qz qw x y z\n1 2 3 4 5 6 7\n").rows[0], (Row{5, 6, 7, 4, 1, 2, 3}));
}

TEST(PoseTableFile, TakesNumbersWithoutNamesInTheirOrder) {
  const PoseTable table = lines("# poses\n1, 2, 3, 4, 5, 6\n\n7;8;9;10;11,5;12\n");
  EXPECT_EQ(table.rows[0], (Row{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(table.rows[1], (Row{7, 8, 9, 10, 11.5, 12}));
  EXPECT_TRUE(table.names.empty());
  EXPECT_EQ(lines("p7,1 2 3 4 5 6 7\np8,1 2 3 4 5 6 7").names[1], "p8");
  EXPECT_EQ(lines("1 0 0 5 0 1 0 6 0 0 1 7").rows[0].size(), 16U);
}

TEST(PoseTableFile, TakesTheColumnsThatItIsTold) {
  const PoseTable table = lines("9,one,1,2,3,4,5,6\n8,two,1,2,3,4,5,6\n", "-,name,x,y,z,c,b,a");
  EXPECT_EQ(table.rows[0], (Row{1, 2, 3, 6, 5, 4}));
  EXPECT_EQ(table.names[1], "two");
}

TEST(PoseTableFile, LeavesOutTheColumnsThatItIsTold) {
  EXPECT_EQ(lines("9,1,2,3,4,5,6\n", "-,j1,j2,j3,j4,j5,j6").rows[0], (Row{1, 2, 3, 4, 5, 6}));

  // No robtarget of an ABB controller, though it has 17 numbers.
  const std::string joints = ",j1,j2,j3,j4,j5,j6,j7,j8,j9,j10,j11";
  expect_refused("x,y,z,r,s,t" + joints + "\n1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17\n",
                 "line 2: 17 numbers");
  EXPECT_EQ(
      lines("1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17\n", "q,-,-,-,-,-,-,x,y,z,a,b,c,-,-,-,-")
          .rows[0],
      (Row{8, 9, 10, 11, 12, 13}));
}

TEST(PoseTableFile, NamesMayHaveBlanks) {
  const PoseTable table = lines(
      "name,x,y,z,rx,ry,rz\nPose 1,1,2,3,4,5,6\n \"Pose 2\" ,1,2,3,4,5,7\nPose 3,1,2,3,4,5,8\n");
  EXPECT_EQ(table.names, (std::vector<std::string>{"Pose 1", "Pose 2", "Pose 3"}));
}

TEST(PoseTableFile, ReadsProgramsOfRobots) {
  const PoseTable kuka = lines(
      "DEFDAT poses\nDECL E6POS XP1={X 100.5,Y -2,Z 3,A 10,B 20,C 30,S 2,T 35,E1 0.0}\n"
      "DECL E6POS XP2={X 1,Y 2,Z 3,A 4,B 5,C 6,S 2,T 35,E1 0.0}\nENDDAT\n");
  EXPECT_EQ(kuka.rows[0], (Row{100.5, -2, 3, 10, 20, 30}));
  EXPECT_EQ(kuka.names[1], "XP2");

  const PoseTable abb = lines(
      "CONST robtarget p10:=[[1,2,3],[0.5,0.5,0.5,0.5],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n");
  EXPECT_EQ(abb.rows[0], (Row{1, 2, 3, 0.5, 0.5, 0.5, 0.5}));

  const PoseTable whole = lines(
      "CONST robtarget p10:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n"
      "CONST robtarget p20:=[[4,5,6],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n");
  ASSERT_EQ(whole.rows.size(), 2U);
  EXPECT_EQ(whole.rows[1], (Row{4, 5, 6, 0, 1, 0, 0}));
  EXPECT_EQ(whole.names[1], "p20");

  const PoseTable ur = lines("p[0.1,0.2,0.3,1,2,3]\np[0.4,0.5,0.6,1,2,3]\n");
  EXPECT_EQ(ur.rows[1], (Row{0.4, 0.5, 0.6, 1, 2, 3}));
}

TEST(PoseTableFile, ReadsMotionsOfRobots) {
  const PoseTable kuka = lines(
      "PTP {X 1,Y 2,Z 3,A 4,B 5,C 6} C_PTP\nLIN {X 7,Y 8,Z 9,A 4,B 5,C 6}\n"
      "LIN {X 10,Y 8,Z 9,A 4,B 5,C 6} C_DIS\n");
  ASSERT_EQ(kuka.rows.size(), 3U);
  EXPECT_EQ(kuka.rows[2], (Row{10, 8, 9, 4, 5, 6}));
  EXPECT_TRUE(kuka.names.empty());

  const std::string rest = "[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,z50,tool0;\n";
  const PoseTable abb = lines("MoveJ [[1,2,3],[1,0,0,0]," + rest + "MoveL [[4,5,6],[1,0,0,0]," +
                              rest + "MoveL [[7,5,6],[1,0,0,0]," + rest);
  ASSERT_EQ(abb.rows.size(), 3U);
  EXPECT_EQ(abb.rows[2], (Row{7, 5, 6, 1, 0, 0, 0}));
  EXPECT_TRUE(abb.names.empty());

  const PoseTable ur = lines(
      "  movej(p[0.1,0.2,0.3,1,2,3], a=1.4, v=1.05)\n  movel(p[0.4,0.5,0.6,1,2,3], a=1.2, v=0.25)\n"
      "  movel(p[0.7,0.5,0.6,1,2,3])\n");
  ASSERT_EQ(ur.rows.size(), 3U);
  EXPECT_EQ(ur.rows[1], (Row{0.4, 0.5, 0.6, 1, 2, 3}));
  EXPECT_TRUE(ur.names.empty());
  EXPECT_EQ(lines("first = p[1,2,3,4,5,6]\nsecond = p[1,2,3,4,5,7]\n").names[1], "second");
}

TEST(PoseTableFile, ReadsYaml) {
  const PoseTable table = yaml(
      "poses:\n- {name: a, x: 1, y: 2, z: 3, rx: 4, ry: 5, rz: 6}\n- {name: b, rz: 6, ry: 5, rx: "
      "4, "
      "z: 3, y: 2, x: 1}\n");
  EXPECT_EQ(table.rows[0], table.rows[1]);
  EXPECT_EQ(table.names[1], "b");

  const PoseTable numbered = yaml("- {id: 7, x: 1, y: 2, z: 3, rx: 4, ry: 5, rz: 6}\n");
  EXPECT_EQ(numbered.names[0], "7");
  const PoseTable listed = yaml("- {name: 12, pose: [1, 2, 3, 4, 5, 6]}\n");
  EXPECT_EQ(listed.rows[0], (Row{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(listed.names[0], "12");

  const PoseTable ros =
      yaml("- orientation: {x: 0.1, y: 0.2, z: 0.3, w: 0.9}\n  position: {x: 1, y: 2, z: 3}\n");
  EXPECT_EQ(ros.rows[0], (Row{1, 2, 3, 0.9, 0.1, 0.2, 0.3}));

  const PoseTable matrix = yaml("- [[1, 0, 0, 5], [0, 1, 0, 6], [0, 0, 1, 7], [0, 0, 0, 1]]\n");
  EXPECT_EQ(matrix.rows[0].size(), 16U);
  EXPECT_EQ(matrix.rows[0][3], 5);
  EXPECT_EQ(yaml("- rotation: [4, 5, 6]\n  translation: [1, 2, 3]\n").rows[0],
            (Row{1, 2, 3, 4, 5, 6}));
}

TEST(PoseTableFile, RefusesOtherFiles) {
  expect_refused("", "no poses");
  expect_refused("x,y,z\n1,2,3\n", "no poses");
  expect_refused("x,y,z,p,q,s\n1,2,3,4,5,six\n", "line 2: 5 numbers");
  expect_refused("x,y,z,a,b,c\n1,2,3,4,5\n", "line 2: 5 columns; expected 6");
  expect_refused("1,2,3,4,5,6\n1,2,3,4,5,6,7\n", "line 2: 7 numbers");
  expect_refused("a,1,2,3,4,5,6\na,1,2,3,4,5,7\nb,1,2,3,4,5,8\n", "two poses are named a");
  EXPECT_THROW(yaml("a: 1\n"), Error);
  EXPECT_THROW(yaml("- [1, 2\n"), Error);
}

TEST(PoseTableFile, ReadsWhatItWrites) {
  const PoseTable table{{"one", "two"}, {{1, 2, 3, 4, 5, 6}, {1.5, 2, 3, 4, 5, 6}}};
  const PoseTable read = lines(text_of(table, "name,x,y,z,a,b,c"));
  EXPECT_EQ(read.rows, table.rows);
  EXPECT_EQ(read.names, table.names);
}

}  // namespace slipstream::pose_table_file_test
