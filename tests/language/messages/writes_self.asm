asm writes_self
import StandardLibrary
signature:
  static a: Agent
definitions:
  main rule r_Main = self := a  //~ A034
