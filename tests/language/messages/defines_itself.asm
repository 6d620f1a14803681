asm defines_itself
import StandardLibrary
signature:
  abstract domain Robot
  static rob: Robot
definitions:
  function rob = rob  //~ W024
  main rule r_Main = skip
