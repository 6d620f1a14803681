asm writes_constant
import StandardLibrary
signature:
  abstract domain Robot
  static rob: Robot
definitions:
  main rule r_Main = rob := undef  //~ A016
