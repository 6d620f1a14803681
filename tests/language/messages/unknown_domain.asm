asm unknown_domain
import StandardLibrary
signature:
  enum domain Colour = {RED | GREEN}
  controlled c: Color  //~ A004
definitions:
  main rule r_Main = skip
