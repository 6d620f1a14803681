// any number of messages can be sent in a step, also alike; they are received one a step, in order
asm messages_many
import StandardLibrary
import CommonBehavior
signature:
  domain Boss subsetof Agent
  domain Worker subsetof Agent
  static boss: Boss
  static bob: Worker
  controlled sent: Boolean
  controlled job: Integer
  controlled jobs: Integer
definitions:
  rule r_boss =
    if sent != true then
      par
        forall $n in [1 : 3] do r_wsend[bob, "dig", $n]
        r_wsend[bob, "dig", 3]
        sent := true
      endpar
    endif
  rule r_worker =
    par
      r_wreceive[boss, "dig", job]
      if isDef(nextRequest(self)) then jobs := jobs + 1 endif
    endpar
  main rule r_Main = par program(boss) program(bob) endpar
default init s0:
  function jobs = 0
  agent Boss: r_boss[]
  agent Worker: r_worker[]
//= step 1: sent := true, boss -> bob: dig(1), boss -> bob: dig(2), boss -> bob: dig(3), boss -> bob: dig(3), status(bob) := BLOCKED
//= step 2: job := 1, jobs := 1, status(bob) := READY
//= step 3: job := 2, jobs := 2
//= step 4: job := 3, jobs := 3
//= step 5: job := 3, jobs := 4
//= step 6: status(bob) := BLOCKED
