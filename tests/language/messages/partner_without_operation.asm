asm partner_without_operation
import StandardLibrary
import CommonBehavior
signature:
  domain Planner subsetof Agent
  static planner: Planner
  out plan: Prod(Agent, Integer) -> Integer
definitions:
  main rule r_Main = r_wsend[planner, "pln", 3]  //~ A040
