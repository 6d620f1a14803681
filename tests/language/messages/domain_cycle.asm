asm domain_cycle
import StandardLibrary
signature:
  domain Tree subsetof Seq(Tree)  //~ A033
  controlled t: Tree
definitions:
  main rule r_Main = skip
