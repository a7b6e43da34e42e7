// @ts-check
/**
 * Every word that the page itself says, in English and Chinese: one table.
 *
 * What vehicles and missions say is shown as it comes; ``of`` translates names that are the same
 * everywhere (limits, alarms). {0}, {1}: what is put in.
 */

/** @type {Readonly<Record<string, readonly [string, string]>>} */
export const WORDS = {
  // the page
  title: ['Cockpit', '驾驶舱'],
  language: ['中文', 'English'],
  theme: ['Theme', '主题'],
  dark: ['Dark', '深色'],
  sun: ['Sunlight', '强光'],
  red: ['Red light', '红光'],
  sound: ['Sound', '声音'],
  on: ['on', '开'],
  off: ['off', '关'],
  rooms: ['Rooms', '面板'],
  settings: ['Settings', '设置'],
  keys_are: ['X stop · W surface\nEsc leaves a text field\nOn the chart: arrows, + −, 0 all, F follow',
    'X 停止 · W 上浮\nEsc 离开输入框\n海图：方向键，+ −，0 全部，F 跟随'],
  urgent: ['Stop and surface', '停止与上浮'],
  values: ['Values', '数值'],
  review_room: ['Recording', '回放'],
  vehicle: ['Vehicle', '航行器'],

  // where it comes from
  live: ['LIVE', '实时'],
  simulation: ['SIMULATION', '仿真'],
  review: ['RECORDING', '回放'],
  modem: ['MODEM', '水声'],
  opening: ['Looking for the console …', '正在连接控制台……'],
  lost: ['The console does not answer for {0}', '控制台已 {0} 无应答'],
  silent: ['NOTHING NEW of the vehicle for {0}: all below is of that time',
    '航行器已 {0} 没有新数据：以下均为当时的数据'],
  unheard: ['Nothing has been heard of the vehicle so far', '尚未收到航行器的任何数据'],
  refused_page: ['This page is not admitted: open the address that the console printed',
    '此页面未获准：请打开控制台给出的地址'],
  read_only: ['No commands: this is a recording', '不可下令：这是回放'],
  thin: ['by the command port alone: what is missing here does not come that way',
    '仅经指令端口：未显示的数据无法由此传送'],
  link: ['Link', '链路'],
  heard: ['heard', '收到'],

  // ages and numbers
  seconds: ['{0} s', '{0} 秒'],
  minutes: ['{0} min', '{0} 分'],
  hours: ['{0} h', '{0} 小时'],
  ago: ['{0} ago', '{0}前'],
  unknown: ['not known', '未知'],
  old: ['OLD', '过时'],
  never: ['never', '从未'],

  // values
  depth: ['Depth', '深度'],
  altitude: ['Altitude', '离底高度'],
  heading: ['Heading', '航向'],
  speed: ['Speed', '速度'],
  battery: ['Battery', '电池'],
  pitch: ['Pitch', '纵倾'],
  roll: ['Roll', '横倾'],
  fix: ['Fix', '定位'],
  report: ['Report', '报告'],
  uncertainty: ['95 % within', '95 % 半径'],
  floor: ['Floor', '海底'],

  // chart
  chart: ['Chart', '海图'],
  known_now: ['Known now', '事后已知'],
  comparing: ['Compare', '对比'],
  compare: ['Compare with', '对比'],
  compare_none: ['Compare with …', '对比……'],
  aligned: ['Aligned by', '对齐方式'],
  by_start: ['by start', '按起点'],
  by_clock: ['by clock', '按时钟'],
  working_out: ['Being worked out …', '正在计算……'],
  was_off: ['estimate off by {0} here', '此处估计偏差 {0}'],
  off_in_all: ['{0} in the mean, {1} at most', '平均 {0}，最大 {1}'],
  apart_at: ['{0} from the other at {1}', '与另一次（{1}）相距 {0}'],
  charts: ['Charts', '底图'],
  no_charts: ['None: open a file, or drop it on the chart', '无：请打开文件，或将其拖到海图上'],
  open_chart: ['Open …', '打开……'],
  opacity: ['Opacity of', '不透明度'],
  higher: ['Higher', '上移'],
  lower: ['Lower', '下移'],
  charted: ['charted {0}', '图载水深 {0}'],
  chart_keys: ['Chart: arrow keys move it, + and - zoom, 0 shows all, F follows the vehicle',
    '海图：方向键移动，+ 和 - 缩放，0 显示全部，F 跟随航行器'],
  zoom_in: ['Nearer', '放大'],
  zoom_out: ['Farther', '缩小'],
  fit: ['Show all', '显示全部'],
  follow: ['Follow the vehicle', '跟随航行器'],
  home: ['Home', '起点'],
  target: ['Target', '目标'],
  radius: ['Radius', '半径'],
  no_place: ['No place is known so far', '尚无已知位置'],
  reckoned: ['dead reckoning for {0}', '航位推算已 {0}'],
  of_vehicle: ['from the vehicle', '距航行器'],
  of_home: ['from home', '距起点'],

  // states
  states: ['State', '状态'],
  state: ['State', '状态'],
  reason: ['Why', '原因'],
  setpoint: ['Set', '设定'],
  leg: ['Leg', '航段'],
  until: ['Until', '直到'],
  now: ['now', '当前'],
  timeout: ['Timeout', '超时'],
  mission: ['Mission', '任务'],
  no_mission: ['no mission', '无任务'],
  not_started: ['not under way', '未执行'],
  legs: ['Legs', '航段'],
  status: ['State', '状态'],
  no_picture: ['There is no picture of this mission', '此任务没有图'],

  // margins
  margins: ['Margins', '余量'],
  to_depth: ['Depth', '深度'],
  to_radius: ['Radius', '半径'],
  to_time: ['Time', '时间'],
  to_voltage: ['Voltage', '电压'],
  beyond: ['BEYOND by {0}', '超限 {0}'],
  of: ['of {0}', '限值 {0}'],
  reaches: ['gone in {0}', '{0} 后用尽'],

  // strips
  strips: ['Strips', '曲线'],
  all: ['All', '全部'],

  // journal
  journal: ['Journal', '日志'],
  search: ['Search', '搜索'],
  missing: ['{0} lines are missing here', '此处缺少 {0} 行'],
  nothing: ['Nothing so far', '暂无'],

  // alarms
  silence: ['Silence', '静音'],
  silenced: ['silenced', '已静音'],
  alarms: ['Alarms', '告警'],

  // commands
  command: ['Command', '指令'],
  stop: ['STOP', '停止'],
  stop_says: ['everything off', '全部关停'],
  surface: ['SURFACE', '上浮'],
  surface_says: ['come up', '返回水面'],
  start: ['Start', '开始'],
  clear: ['Clear', '清除'],
  upload: ['Upload', '上传'],
  take: ['Take command', '接管指挥'],
  release: ['Give up command', '交出指挥'],
  limits: ['Limits', '限值'],
  set_limits: ['Set limits', '设定限值'],
  commander: ['Commander', '指挥者'],
  nobody: ['nobody', '无人'],
  us: ['this console', '本控制台'],
  again: ['Press again: {0}', '再按一次：{0}'],
  will_start: ['start {0} on {1}', '在 {1} 上开始 {0}'],
  will_clear: ['clear the emergency and the mission on {1}', '清除 {1} 上的应急状态和任务'],
  will_upload: ['upload {0} to {1}', '将 {0} 上传到 {1}'],
  will_take: ['take command of {1}', '接管 {1}'],
  will_release: ['give up command of {1}', '交出 {1} 的指挥'],
  will_limits: ['set limits on {1}: {0}', '在 {1} 上设定限值：{0}'],
  sent: ['sent', '已发送'],
  acknowledged: ['acknowledged', '已确认'],
  progress: ['under way', '进行中'],
  confirmed: ['CONFIRMED by the vehicle', '航行器已证实'],
  unconfirmed: ['acknowledged, nothing confirms it', '已确认，尚无证实'],
  contradicted: ['CONTRADICTED by reports', '与报告矛盾'],
  refused: ['REFUSED', '被拒绝'],
  unanswered: ['UNANSWERED', '无应答'],
  unsent: ['NOT SENT', '未发送'],
  waiting: ['waits', '等待'],
  done: ['Commands so far', '已发指令'],
  on_board: ['On board', '艇上'],
  planned: ['Planned', '计划'],
  same: ['the same', '一致'],
  different: ['DIFFERENT', '不一致'],
  choose: ['Mission to upload', '待上传任务'],
  choose_shipped: ['Shipped …', '自带任务……'],
  choose_file: ['File …', '文件……'],
  too_large: ['{0} is no mission: more than 1 MB', '{0} 不是任务：超过 1 MB'],
  proof_time: ['proved: at most {0}', '已证明：最长 {0}'],
  proof_range: ['{0} from home', '离起点 {0}'],
  proof_depth: ['{0} deep', '深 {0}'],
  checklist: ['Checklist', '检查单'],
  seen_here: ['Seen from here', '由此可见'],
  limits_off: ['off: {0}', '未启用：{0}'],
  limits_on: ['on: {0}', '已启用：{0}'],
  sensors: ['Sensors', '传感器'],
  not_believed: ['not to be believed now: {0}', '当前不可信：{0}'],
  none_stands: ['none', '无'],
  no_points: ['This vehicle has no points to be looked at by hand', '此航行器没有人工检查项'],

  // stick
  stick: ['Stick', '手柄'],
  stick_off: ['Off', '关'],
  stick_take: ['Take the stick', '启用手柄'],
  stick_drop: ['Put the stick away', '停用手柄'],
  stick_pad: ['Pad', '手柄'],
  no_pad: ['No pad: press a button on it, or use the keys', '未见手柄：按其任一键，或使用键盘'],
  stick_ready: ['Ready: hold the dead man\'s button', '就绪：按住安全键'],
  stick_driving: ['DRIVING', '操纵中'],
  stick_hidden: ['Let go: the page is not in front', '已松开：页面不在前台'],
  stick_away: ['Let go of the dead man\'s button, then hold it again: the page was not in front',
    '请松开安全键再按住：页面曾不在前台'],
  stick_still: ['Let go: the pad says nothing new', '已松开：手柄无新数据'],
  stick_gone: ['Let go: the pad is gone', '已松开：手柄已断开'],
  stick_first: ['Let go of the dead man\'s button first', '请先松开安全键'],
  stick_cut: ['Let go: the console does not answer', '已松开：控制台无应答'],
  stick_not_ours: ['Another commands: {0}', '他人指挥中：{0}'],
  stick_live_only: ['Only with a live vehicle', '仅限实时航行器'],
  stick_not_modem: ['Not by modem', '水声链路不可用'],
  answer: ['answer', '应答'],
  weaker: ['Weaker', '减弱'],
  stronger: ['Stronger', '加强'],
  stick_keys: ['Keys: hold Shift; arrows ahead, astern, turn; Page Up and Page Down up and down; 1 to 9 how strong',
    '键盘：按住 Shift；方向键前进、后退、转向；Page Up/Down 上浮、下潜；1 至 9 力度'],
  stick_pad_says: ['Pad: hold the left shoulder button; left stick ahead and turn, right stick up and down',
    '手柄：按住左肩键；左摇杆前进和转向，右摇杆上下'],
  strength: ['Strength', '力度'],
  surge: ['Ahead', '前进'],
  turn: ['Turn', '转向'],
  heave: ['Up', '上升'],
  held: ['held', '按住'],
  told: ['What was sent', '已发送'],

  // plan
  planner: ['Plan', '计划'],
  plan_text: ['Text of the plan. Control and space completes, control Z undoes',
    '计划文本。Ctrl+空格补全，Ctrl+Z 撤销'],
  plan_chart_keys: ['Chart of the plan: arrow keys move it, N and P choose a place, Enter takes it up and puts it down, A adds in the middle, Delete removes',
    '计划海图：方向键移动，N 和 P 选点，Enter 拾起并放下，A 在中央添加，Delete 删除'],
  plan_template: ['Template …', '模板……'],
  plan_save: ['Save', '保存'],
  plan_undo: ['Undo', '撤销'],
  plan_redo: ['Redo', '重做'],
  plan_kind: ['What is added', '添加内容'],
  plan_add: ['Add', '添加'],
  plan_press: ['Press on the chart', '请点海图'],
  plan_remove: ['Remove', '删除'],
  plan_goto: ['Goto', '航点'],
  plan_point: ['Point of a row', '序列中的点'],
  plan_rows: ['Rows', '测线'],
  plan_loiter: ['Loiter', '盘旋'],
  plan_keep_out: ['Keep-out area', '禁入区'],
  plan_keep_in: ['Keep-in area', '限定区'],
  plan_no_home: ['The text names no home: there is no place to draw', '文本未写起点：无处可绘'],
  still_water: ['planned, in still water', '静水中的计划'],
  still_flown: ['the planned track is being worked out …', '正在计算计划航迹……'],
  still_none: ['no planned track: {0}', '无计划航迹：{0}'],
  plan_proof: ['Proof', '证明'],
  plan_old: ['of the text of {0} ago, the newest is being proved: {1}', '{0} 前文本的结果，新文本正在证明：{1}'],
  plan_refused: ['Refused: {0}', '未通过：{0}'],
  plan_path: ['Worst case, leg by leg, and what is assumed', '最坏情况（逐航段）与假设'],
  plan_changed: ['The text has changed meanwhile: do it again', '文本已变，请重做'],
  plan_here: ['here', '此处'],
  plan_compare: ['Compare', '比较'],
  plan_same: ['No difference for the vehicle', '对航行器没有差别'],
  plan_left_out: ['left out: {0}', '未导入：{0}'],
  ghost: ['Ghost flight', '虚拟航行'],
  ghost_sea: ['Sea', '海况'],
  ghost_sea_says: ['KEY=VALUE, as simulate --set has them: current=0.3@45 floor=20 fault=depth_frozen@120+60',
    '键=值，同 simulate --set：current=0.3@45 floor=20 fault=depth_frozen@120+60'],
  ghost_seed: ['Seed', '种子'],
  ghost_fly: ['Fly', '试航'],
  ghost_cancel: ['Cancel', '取消'],
  ghost_flies: ['It flies …', '试航中……'],
  ghost_time: ['Time of the ghost flight', '虚拟航行时间'],
  ghost_completed: ['COMPLETED', '完成'],
  ghost_emergency: ['EMERGENCY', '应急'],
  ghost_failed: ['FAILED', '失败'],
  ghost_up: ['up {0} times', '上浮 {0} 次'],
  ghost_error: ['{0} off at the end', '终点偏差 {0}'],
  ghost_calm: ['calm', '平静'],
  ghost_at: ['shown at {0}', '显示时刻 {0}'],
  ghost_nowhere: ['no home, no track', '无起点，无航迹'],
  import_busy: ['{0} is being imported for {1} …', '正在导入 {0}，已 {1}……'],
  import_home: ['Home: latitude, longitude; or first', '起点：纬度, 经度；或 first'],
  import_depth: ['Depth, m', '深度，米'],
  import_gear: ['Gear', '档位'],
  import_pick: ['Route', '航线'],
  import_swap: ['Exchanged', '经纬互换'],
  import_again: ['Import', '导入'],
  import_drop: ['Close', '关闭'],

  // review
  play: ['Play', '播放'],
  pause: ['Pause', '暂停'],
  speed_of: ['Speed', '倍速'],
  event_before: ['Event before', '上一事件'],
  event_after: ['Next event', '下一事件'],
  scrub: ['Time of the recording', '回放时间'],
};

/** Names that vehicles use, in Chinese. @type {Readonly<Record<string, string>>} */
const NAMES = {
  emergency: '应急',
  limit: '超限',
  'stop not obeyed': '停止未执行',
  'old report': '报告过时',
  'no fix': '无定位',
  refused: '指令被拒',
  battery: '电池',
  'link away': '链路断开',
  'NOT SENT': '指令未发出',
  disk: '磁盘',
  'black box': '黑匣子',
  clock: '时钟',
  broken: '损坏',
  receiver: '定位接收机',
  'surface unproved': '水面未证实',
  'no contact': '失去联系',
  OVERDUE: '逾期未归',
};

/** @typedef {'en' | 'zh'} Language */

/** @type {Language} */
let language = 'en';

/** @param {Language} to */
export function setLanguage(to) {
  language = to;
}

export function inLanguage() {
  return language;
}

/** What the page says. @param {string} key Throws an Error for one that the table has not.
 * @param {...(string | number)} put */
export function word(key, ...put) {
  const row = WORDS[key];
  if (row === undefined) throw new Error(`no word ${key}`);
  return put.reduce((/** @type {string} */ text, value, i) => text.replaceAll(`{${i}}`, `${value}`),
    row[language === 'zh' ? 1 : 0]);
}

/** A name of the vehicle's, for whoever reads. @param {string} name */
export function named(name) {
  return language === 'zh' ? (NAMES[name] ?? name) : name;
}
