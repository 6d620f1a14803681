// every agent runs the program of its domain; `self` is the agent
asm agents
import StandardLibrary
signature:
  domain Ping subsetof Agent
  domain Pong subsetof Agent
  static a: Ping
  static b: Ping
  static c: Pong
  controlled n: Agent -> Integer
definitions:
  rule r_ping = n(self) := 1
  rule r_pong = n(self) := 2
  main rule r_Main = forall $x in Agent do program($x)
default init s0:
  agent Ping: r_ping[]
  agent Pong: r_pong[]
//= step 1: n(a) := 1, n(b) := 1, n(c) := 2
