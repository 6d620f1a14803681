// a reply goes to the call it answers: both clients ask in one step, and each gets its own
asm messages_call
import StandardLibrary
import CommonBehavior
signature:
  domain Client subsetof Agent
  domain Server subsetof Agent
  static c1: Client
  static c2: Client
  static srv: Server
  //@Backref
  shared client: Agent -> Agent
  controlled asked: Client -> Integer
  controlled got: Client -> Integer
  controlled given: Server -> Integer
definitions:
  rule r_client = r_wsendreceive[srv, "r_double(Agent,Integer)", asked(self), got(self)]
  rule r_server =
    if isDef(nextRequest(self)) then
      seq
        r_wreceive[client(self), "r_double(Agent,Integer)", given(self)]
        r_wreply[client(self), "r_double(Agent,Integer)", given(self) * 2]
      endseq
    endif
  main rule r_Main = forall $a in Agent with isDef(program($a)) do program($a)
default init s0:
  function asked($c in Client) = if $c = c1 then 10 else 20 endif
  agent Client: r_client[]
  agent Server: r_server[]
//= step 1: c1 -> srv: call double(10), c2 -> srv: call double(20)
//= step 2: given(srv) := 10, status(srv) := READY, srv -> c1: reply to double: 20
//= step 3: got(c1) := 20, given(srv) := 20, srv -> c2: reply to double: 40
//= step 4: got(c2) := 40
//= step 5: nothing
