asm initialises_self
import StandardLibrary
signature:
  static a: Agent
definitions:
  main rule r_Main = skip
default init s0:
  function self = a  //~ A021
