// `self` is restored when a program is done
asm agents_nested
import StandardLibrary
signature:
  domain Outer subsetof Agent
  domain Inner subsetof Agent
  static a: Outer
  static b: Inner
  controlled n: Agent -> Integer
  controlled m: Agent -> Integer
definitions:
  rule r_inner = n(self) := 1
  rule r_outer = par program(b)  m(self) := 2 endpar
  main rule r_Main = program(a)
default init s0:
  agent Outer: r_outer[]
  agent Inner: r_inner[]
//= step 1: m(a) := 2, n(b) := 1
