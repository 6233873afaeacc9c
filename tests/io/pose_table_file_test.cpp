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
  EXPECT_EQ(lines("9,1,2,3,4,5,6\n", "-,x,y,z,a,b,c").rows[0], (Row{1, 2, 3, 4, 5, 6}));

  // No robtarget of an ABB controller, though it has 17 numbers.
  const std::string joints = ",e1,e2,e3,e4,e5,e6,e7,e8,e9,e10,e11";
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

TEST(PoseTableFile, ReadsAPoseOfSeveralLines) {
  const std::string config = "UF : 0, UT : 1, CONFIG : 'N U T, 0, 0, 0',\n";
  const PoseTable fanuc =
      lines("/POS\nP[1]{\n  GP1:\n " + config + " X = 1.5 mm, Y = -2 mm, Z = 3 mm,\n" +
            " W = 4 deg, P = 5 deg, R = 6 deg\n};\nP[2]{\n  GP1:\n " + config +
            " X = 7 mm, Y = 8 mm, Z = 9 mm,\n W = 4 deg, P = 5 deg, R = 6 deg\n};\n/END\n");
  ASSERT_EQ(fanuc.rows.size(), 2U);
  EXPECT_EQ(fanuc.rows[0], (Row{1.5, -2, 3, 4, 5, 6}));
  expect_refused(
      "/POS\nP[1]{\n GP1:\n J1 = 1 deg, J2 = 2 deg, J3 = 3 deg,\n J4 = 4 deg, J5 = 5 "
      "deg, J6 = 6 deg\n};\n",
      "line 2");
}

TEST(PoseTableFile, RefusesJointsAndOtherMotions) {
  const std::string kuka = "{X 1,Y 2,Z 3,A 4,B 5,C 6}", pose = "LIN " + kuka + "\n";
  const std::string abb = "[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
  const std::string ur = "p[0.1,0.2,0.3,1,2,3]";

  // KUKA
  for (const char* const joints :
       {"PTP {A1 0,A2 -90,A3 90,A4 0,A5 45,A6 0}",
        "PTP {A1 0, A2 -90, A3 90, A4 0, A5 45, A6 0, E1 0}",
        "PTP {A1 0, A2 -90, A3 90, A4 0, A5 45, A6 0, E1 0, E2 0, E3 0, E4 0, E5 0, E6 0}",
        "DECL E6AXIS XHOME={A1 0.0,A2 -90,A3 90,A4 0,A5 0,A6 0,E1 0,E2 0,E3 0,E4 0,E5 0,E6 0}",
        "DECL AXIS H={A1 0.0,A2 -90,A3 90,A4 0,A5 0,A6 0}"}) {
    expect_refused(pose + joints, "line 2");
    expect_refused(std::string(joints) + "\n" + pose, "joint");
  }
  expect_refused(pose + "CIRC " + kuka + "," + kuka, "line 2: a circular motion");
  expect_refused(pose + "LIN_REL " + kuka, "line 2: a relative motion");
  EXPECT_EQ(lines(";FOLD LIN P3 Vel=2 m/s Tool[1] Base[0];%P 1:2, 3:4, 5:2\n" + pose).rows.size(),
            1U);

  // ABB
  expect_refused("MoveAbsJ [[0,-90,90,0,45,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,z50,tool0;",
                 "joint angles");
  expect_refused("CONST jointtarget j:=[[0,-90,90,0,45,0],[9E9,9E9,9E9,9E9,9E9,9E9]];",
                 "joint angles");
  expect_refused("MoveC " + abb + "," + abb + ",v100,z50,tool0;", "circular");
  expect_refused("MoveL RelTool(" + abb + ",0,0,50),v100,z50,tool0;", "relative");
  EXPECT_EQ(lines("! " + abb + "\nMoveL " + abb + ",v100,fine,tool0;").rows.size(), 1U);

  // UR and Doosan
  expect_refused("movej([0,-1.57,1.57,0,0.7,0])", "joint angles");
  expect_refused("  movej( [0,-1.57,1.57,0,0.7,0], a=1.4, v=1.05)", "joint angles");
  expect_refused("servoj([0,-1.57,1.57,0,0.7,0], 0, 0, 0.008)", "joint angles");
  expect_refused("movec(" + ur + ", " + ur + ", a=1.2, v=0.25)", "circular");
  expect_refused(
      "timestamp actual_q_0 actual_q_1 actual_q_2 actual_q_3 actual_q_4 actual_q_5\n"
      "0.1 0 -1.57 1.57 0 0.7 0\n",
      "line 2: the numbers timestamp, actualq0");
  expect_refused("home = posj(0,0,90,0,90,0)", "joint angles");
  expect_refused("movec(posx(1,2,3,4,5,6), posx(1,2,3,4,5,6))", "circular");
  EXPECT_EQ(lines("p1 = posx(1,2,3,4,5,6)").rows.size(), 1U);

  // Kawasaki and Yaskawa
  expect_refused("JT1 JT2 JT3 JT4 JT5 JT6\n0 -90 90 0 45 0\n", "line 2: the numbers jt1, jt2");
  expect_refused("JMOVE #[0,-90,90,0,45,0]", "joint angles");
  expect_refused("///POSTYPE PULSE\n///PULSE\nC00000=100,200,300,400,500,600\n",
                 "line 1: positions in pulses");
  EXPECT_EQ(lines("///POSTYPE BASE\n///RECTAN\nC00000=1,2,3,4,5,6\n").rows.size(), 1U);
  expect_refused("S,L,U,R,B,T\n0,-90,90,0,45,0\n", "line 2: the numbers s, l");

  // Joints beside a pose are left out of YAML; alone they are refused.
  EXPECT_EQ(yaml("- {q: [1, 2, 3, 4, 5, 6], pose: [7, 8, 9, 0, 0, 1]}\n").rows[0],
            (Row{7, 8, 9, 0, 0, 1}));
  EXPECT_THROW(yaml("- {joints: [1, 2, 3, 4, 5, 6]}\n"), Error);
  EXPECT_THROW(yaml("- {name: [a, b, c, d, e, f], position: [1, 2, 3, 4, 5, 6]}\n"), Error);
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
